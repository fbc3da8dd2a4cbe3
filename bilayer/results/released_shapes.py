"""The shapes of a result that can be shown, each in its body frame, the upper side up.

What is held by supports, or lies on obstacles, is shown where it is.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from bilayer.errors import InputError
from bilayer.geometry.surface import Surface
from bilayer.measures.body_frame import upright_frame
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.caveats import caveats
from bilayer.results.comparison import result_label
from bilayer.results.schema import TIMES_FOUND, result_specimen
from bilayer.results.table import load_titles, shape_title

MM_PER_M = 1e3


@dataclass(frozen=True)
class Shape:
    """One shape to show.

    Parameters
    ----------
    title : str
        Its prestretch, or the load or time that differs; of the states of a search their
        number and energy.
    note : str
        What to know of it, such as where the path stopped; "" for nothing.
    surface : Surface
        In the body frame with the sheet's upper side up, mm; held shapes where they are.
    milestone : int
        Its place in the result.
    """

    title: str
    note: str
    surface: Surface
    milestone: int = 0


def _state_title(number: int, milestone: xr.Dataset) -> str:
    """Return the title of one of several states at one prestretch; an empty text for others."""
    if TIMES_FOUND not in milestone:
        return ""
    return f"{number}: {1e3 * float(milestone['energy'].sum()):.4f} mJ"


def released_shapes(result: xr.Dataset, mesh: PlanarMesh) -> list[Shape]:
    """Return the shapes of all milestones that have one, the upper side of the sheet up.

    A milestone that was not reached has the last shape on the way to it.

    Parameters
    ----------
    result : Dataset
        Along its milestones; see `bilayer.results.milestones.along_milestones`.
    mesh : PlanarMesh
        Its mesh.

    Raises
    ------
    InputError
        There is none.
    """
    loads = load_titles(result)
    specimen = result_specimen(result)
    held = bool(specimen.supports or specimen.obstacles)
    shapes = []
    for k, note in enumerate(caveats(result)):
        milestone = result.isel(prestretch=k)
        position = milestone["position"].values
        if not milestone["converged"] and "last_position" in milestone:
            position = milestone["last_position"].values
            note = f"stopped at {float(milestone['last_prestretch']):.4g}"
        if np.isfinite(position).all():
            placed = position if held else upright_frame(mesh, position).coordinates(position)
            upright = MM_PER_M * placed
            title = _state_title(k, milestone) or shape_title(milestone) + loads[k]
            shapes.append(Shape(title, note, Surface(upright, mesh.triangles), k))
    if not shapes:
        raise InputError(f"the result of {result_label(result)} holds no shape to draw")
    return shapes
