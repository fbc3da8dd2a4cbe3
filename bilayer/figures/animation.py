"""The shapes of a result one after the other, as a GIF or a film.

Every picture is an equilibrium that was computed; nothing is blended between two of them.
"""

import shutil
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg

from bilayer.errors import ComputationError
from bilayer.figures.shape import draw_frame, frame_of, view_of
from bilayer.figures.style import new_figure, print_style
from bilayer.results.milestones import along_milestones
from bilayer.results.released_shapes import released_shapes
from bilayer.results.schema import result_mesh
from bilayer.runtime.output_file import check_writable, whole_file
from bilayer.validation import one_of, positive

ENDINGS = (".gif", ".mp4")
DOTS_PER_INCH = 120
SIZE = (5.0, 4.0)
"""Of a picture, inches."""
HOLD = 0.25
"""Share of the time for which the last picture stays."""


def save_animation(
    result: xr.Dataset,
    path: str | Path,
    *,
    view: str | tuple[float, float] = "isometric",
    seconds: float = 5.0,
) -> None:
    """Write the shapes of a result as an animation, one picture for each milestone.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`; `bilayer.solvers.between.solve_between` computes equilibria
        between its milestones.
    path : path-like
        A file in .gif or .mp4.
    view : str or (float, float)
        See `bilayer.draw_shapes`.
    seconds : float
        Duration; the last picture stays for a quarter of it.

    Raises
    ------
    InputError
        The result holds no shape, the ending is another one, or the folder cannot be written.
    ComputationError
        Writing failed, or the program ffmpeg is not there for an .mp4.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.02, 1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> import pathlib, tempfile
    >>> bilayer.save_animation(result, pathlib.Path(tempfile.mkdtemp()) / "rise.gif")
    """
    check_animation_output(path)
    result = along_milestones(result)
    mesh = result_mesh(result)
    shapes = released_shapes(result.isel(prestretch=result["converged"].values == 1), mesh)
    seen = view_of(view)
    frame = frame_of(seen, shapes)
    pictures = [*shapes, *[shapes[-1]] * max(1, round(HOLD / (1 - HOLD) * len(shapes)))]
    rate: Any = len(pictures) / positive("seconds", seconds)
    with print_style(), tempfile.TemporaryDirectory() as folder:
        figure = new_figure(*SIZE)
        FigureCanvasAgg(figure)
        film = Path(folder, f"film{Path(path).suffix.lower()}")
        writer = _writer(film, rate)
        with writer.saving(figure, str(film), DOTS_PER_INCH):
            for shape in pictures:
                figure.clear()
                draw_frame(figure.add_subplot(), shape, mesh, seen, frame)
                writer.grab_frame()
        with whole_file(path, "animation") as partial:
            shutil.copyfile(film, partial)


def check_animation_output(path: str | Path, inputs: Iterable[str | Path] = ()) -> None:
    """Raise InputError unless an animation can be written: before it is computed."""
    check_writable(path, inputs)
    one_of(f"ending of animation {path}", Path(path).suffix.lower(), ENDINGS)
    if Path(path).suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise ComputationError("ffmpeg is not installed, which writes .mp4: expected it, or a .gif")


def _writer(film: Path, rate: Any) -> Any:
    from matplotlib.animation import FFMpegWriter, PillowWriter  # few need it

    if film.suffix == ".gif":
        return PillowWriter(fps=rate)
    return FFMpegWriter(fps=rate, codec="libx264", extra_args=["-pix_fmt", "yuv420p"])
