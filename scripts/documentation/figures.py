"""The pictures of an example of the gallery: the figures that it holds when a block has run."""

from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

DOTS_PER_INCH = 130


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the new figures of an example and return the text that shows them.

    The figures of `bilayer` are not those of pyplot, which the gallery would find by itself.
    """
    held = block_vars["example_globals"]
    shown: set[int] = held.setdefault("__shown_figures__", set())
    figures = [value for value in held.values() if isinstance(value, Figure)]
    new = [figure for figure in figures if id(figure) not in shown]
    shown |= {id(figure) for figure in new}
    paths = [next(block_vars["image_path_iterator"]) for _ in new]
    for figure, path in zip(new, paths, strict=True):
        FigureCanvasAgg(figure)
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=DOTS_PER_INCH, bbox_inches="tight")
    return figure_rst(paths, gallery_conf["src_dir"])
