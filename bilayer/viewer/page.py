"""The page: one HTML file that holds the scene, the program that shows it, and its style."""

import html
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import xarray as xr

from bilayer.mechanics.selection import ScalarField
from bilayer.results.schema import result_specimen
from bilayer.runtime.output_file import whole_file
from bilayer.viewer.scene import scene_of

HEIGHT = 560
"""Of the frame in a notebook, pixels."""


@dataclass(frozen=True)
class Page:
    """A page; in a notebook it shows itself.

    Parameters
    ----------
    text : str
        HTML that needs no other file.
    """

    text: str

    def save(self, path: str | Path) -> None:
        """Write it.

        Raises
        ------
        InputError
            The folder does not exist or cannot be written.
        NotWrittenError
            Writing failed.
        """
        with whole_file(path, "page") as file:
            file.write_text(self.text, encoding="utf-8")

    def _repr_html_(self) -> str:
        """Return a frame of a notebook with the page in it."""
        return (
            f'<iframe srcdoc="{html.escape(self.text)}" width="100%" height="{HEIGHT}" '
            'style="border: 1px solid #ddd" allowfullscreen></iframe>'
        )


def view(
    result: xr.Dataset,
    other: xr.Dataset | None = None,
    title: str = "",
    coloured_by: Sequence[ScalarField] = (),
) -> Page:
    """Return a page that shows a result in three dimensions.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.
    other : Dataset, optional
        Laid over it, see-through.
    title : str
        Of the page; the specimen's name if left out.
    coloured_by : sequence of ScalarField
        Fields that can be chosen as colours, see `bilayer.mechanics.selection.scalar_field`.

    Raises
    ------
    InputError
        A result holds no shape.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> import pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> result = bilayer.solve(specimen, "dshell")
    >>> bilayer.view(result).save(folder / "shape.html")
    """
    here = files("bilayer.viewer")
    scene = scene_of([result] if other is None else [result, other], coloured_by)
    page = here.joinpath("page.html").read_text("utf-8")
    parts = {
        "title": html.escape(title or result_specimen(result).name),
        "style": here.joinpath("page.css").read_text("utf-8"),
        "program": here.joinpath("page.js").read_text("utf-8"),
        # a "<" in a name would end the script
        "scene": json.dumps(scene, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
    }
    return Page(re.sub(r"{{(\w+)}}", lambda mark: parts[mark[1]], page))
