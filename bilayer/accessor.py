"""`result.bilayer`: what a dataset of a result can be asked for, beside what xarray gives.

It is there as soon as a name of the package `bilayer` was used, or with `import bilayer.accessor`.
What a method needs is loaded when it is called.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from bilayer.errors import ComputationError
from bilayer.results.milestones import along_milestones, choose_milestones
from bilayer.results.schema import result_mesh

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bilayer.viewer.page import Page


@xr.register_dataset_accessor("bilayer")
class ResultAccessor:
    """The methods of `result.bilayer`.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.

    Examples
    --------
    >>> result = bilayer.solve(bilayer.paper_specimen(), "dshell")  # doctest: +SKIP
    >>> result.bilayer.plot()  # doctest: +SKIP
    >>> result.bilayer.measures()[["quality", "height"]]  # doctest: +SKIP
    """

    def __init__(self, result: xr.Dataset) -> None:
        self._result = result

    def plot(self, **options: Any) -> "Figure":
        """Return a figure of the shapes; for the options see `bilayer.draw_shapes`."""
        from bilayer.figures import draw_shapes

        return draw_shapes(self._result, **options)

    def view(self, other: xr.Dataset | None = None, title: str = "") -> "Page":
        """Return a page that shows the shapes in three dimensions; see `bilayer.view`."""
        from bilayer.viewer.page import view

        return view(self._result, other, title)

    def measures(self) -> pd.DataFrame:
        """Return the numbers of each milestone in SI units, a row a prestretch.

        Columns are the variables of the result that hold one number a milestone, and `span_x`,
        `span_y`, `span_z`.
        """
        result = along_milestones(self._result)
        table = result[_single(result)].to_dataframe()
        for axis, name in enumerate("xyz"):
            table[f"span_{name}"] = result["span"].values[:, axis]
        return table

    def to_pyvista(self, prestretch: float | None = None) -> Any:
        """Return a shape as a `pyvista.PolyData`, m.

        Its cells have the `region`, its points the `displacement` from the flat sheet.

        Parameters
        ----------
        prestretch : float, optional
            Which milestone; the last one that was reached if left out.

        Raises
        ------
        InputError
            There is no such milestone.
        ComputationError
            The package pyvista is not installed.
        """
        try:
            import pyvista
        except ImportError as error:
            raise ComputationError(
                "pyvista is not installed: expected `pip install bilayer-shells[viewers]`"
            ) from error
        result = along_milestones(self._result)
        wanted = _last_reached(result) if prestretch is None else [prestretch]
        shape = choose_milestones(result, wanted).isel(prestretch=-1)
        position, mesh = shape["position"].values, result_mesh(result)
        faces = np.column_stack([np.full(len(mesh.triangles), 3), mesh.triangles])
        surface = pyvista.PolyData(position, faces.ravel())
        surface.cell_data["region"] = mesh.region
        surface.point_data["displacement"] = position - shape["reference_position"].values
        return surface


def _single(result: xr.Dataset) -> list[str]:
    """Return the variables with one number for each milestone."""
    return [
        str(name)
        for name, variable in result.data_vars.items()
        if variable.dims == ("prestretch",) and variable.dtype.kind in "fiub"
    ]


def _last_reached(result: xr.Dataset) -> Sequence[float]:
    reached = result["prestretch"].values[result["converged"].values == 1]
    return [float(stretch) for stretch in reached[-1:]]
