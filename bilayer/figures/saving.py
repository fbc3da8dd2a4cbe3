"""A figure as a file: whole or not at all, and the same bytes from the same data."""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bilayer.errors import InputError
from bilayer.figures.style import print_style
from bilayer.runtime.input_file import open_input
from bilayer.runtime.output_file import check_writable, whole_file
from bilayer.validation import one_of

DOTS_PER_INCH = 200
_NO_TIME_STAMP: dict[str, dict[str, Any]] = {
    "pdf": {"CreationDate": None},
    "svg": {"Date": None},
    "ps": {},
    "eps": {},
}


def save_figure(figure: Figure, path: str | Path, title: str | None = None) -> None:
    """Write a figure in the format of the file's ending: png, pdf, svg or another of matplotlib's.

    Parameters
    ----------
    figure : Figure
        What is drawn.
    path : path-like
        The file.
    title : str, optional
        Kept in a .png, see `has_title`.

    Raises
    ------
    InputError
        The ending is not one of matplotlib's, or the folder does not exist or cannot be written.
    ComputationError
        Writing failed, for example on a full disk; an earlier file stays as it was.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bilayer
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> figure = bilayer.draw_mesh(bilayer.generate_mesh(bilayer.paper_specimen()))
    >>> bilayer.save_figure(figure, folder / "mesh.pdf")
    """
    kind = _format_of(Path(path))
    metadata = _NO_TIME_STAMP.get(kind)
    if title is not None and kind == "png":
        metadata = {"Title": title}
    FigureCanvasAgg(figure)
    with print_style(), whole_file(path, "figure") as partial:
        figure.savefig(partial, format=kind, dpi=DOTS_PER_INCH, metadata=metadata)


def has_title(path: str | Path, title: str) -> bool:
    """Whether a file is a .png that `save_figure` wrote with this title."""
    try:
        with open_input(path, "figure") as descriptor:
            head = os.read(descriptor, 4096)
    except InputError:
        return False
    return b"tEXtTitle\0" + title.encode() in head


def check_figure_output(path: str | Path, inputs: Iterable[str | Path] = ()) -> None:
    """Raise InputError unless a figure can be written: before it is drawn.

    Parameters
    ----------
    path : path-like
        Where it shall be.
    inputs : iterable of path-like
        Files that are read and must not be lost.
    """
    check_writable(path, inputs)
    _format_of(Path(path))


def _format_of(path: Path) -> str:
    known = FigureCanvasAgg.get_supported_filetypes()
    ending = path.suffix.removeprefix(".").lower()
    if not ending:
        raise InputError(f"figure {path}: has no ending, expected one of {', '.join(known)}")
    return one_of(f"ending of figure {path}", ending, known)
