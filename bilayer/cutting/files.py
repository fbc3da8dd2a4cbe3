"""Cut files: one for each layer, 1:1 in mm, as DXF, SVG or PDF."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.cutting.obstacles import Obstacle, obstacles
from bilayer.cutting.part import Part, part_of
from bilayer.cutting.style import HAIRLINE, Style
from bilayer.cutting.tool_path import registration_marks, tool_path
from bilayer.drawings.packages import package
from bilayer.errors import InputError
from bilayer.runtime.output_file import check_writable, whole_file
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen
from bilayer.validation import not_negative, positive

Lines = Sequence[NDArray[np.float64]]
MM = 1e-3
MARGIN = 2e-3
"""Around everything in SVG and PDF, m."""


@dataclass(frozen=True)
class CutFile:
    """A file that was written.

    Parameters
    ----------
    path : Path
        Where it is.
    part : Part
        What it holds.
    length : float
        Of all cuts, m.
    obstacles : tuple of Obstacle
        What cannot be made.
    """

    path: Path
    part: Part
    length: float
    obstacles: tuple[Obstacle, ...]

    @property
    def words(self) -> str:
        """Description for a report, lengths in mm."""
        width, height = (1e3 * size for size in self.part.size)
        text = f"{self.path}: {self.part.layer}, {width:.4g} x {height:.4g} mm"
        if self.part.is_stretched:
            wide, high = (1e3 * size for size in self.part.stretched_size)
            text += f", to be stretched to {wide:.4g} x {high:.4g} mm"
        return f"{text}; {1e3 * self.length:.4g} mm to cut"


def write_cut_files(
    specimen: Specimen,
    path: str | Path,
    layers: Sequence[str] | None = None,
    stretch: StretchPair | None = None,
    kerf: float = 0.0,
    least_web: float = 1e-3,
    marks: bool = False,
    style: Style | None = None,
) -> list[CutFile]:
    """Write what has to be cut for each layer, in its natural size.

    Parameters
    ----------
    specimen : Specimen
        The sheet.
    path : path-like
        Its ending selects DXF, SVG or PDF. Of several layers each has its name added:
        parts.dxf, parts-kirigami.dxf.
    layers : sequence of str, optional
        Their names; all if left out.
    stretch : (float, float), optional
        Prestretch at which a stretched layer is bonded; the specimen's last milestone if left out.
    kerf : float
        Width of the cut, m: lines lie half of it outside of the part.
    least_web : float
        Narrower webs and slots are named among the obstacles, m.
    marks : bool
        Whether to add registration marks.
    style : Style, optional
        Names and colours of the lines.

    Returns
    -------
    list of CutFile
        From the bottom layer up.

    Raises
    ------
    InputError
        A layer is not there, a length is out of its range, nothing of a part is left, or the
        ending is of no such format.
    NotWrittenError
        Writing failed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bilayer
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> parts = bilayer.write_cut_files(bilayer.paper_specimen(), folder / "parts.svg")
    >>> sorted(path.name for path in folder.iterdir())
    ['parts-kirigami.svg', 'parts-substrate.svg']
    """
    target = Path(path)
    write = _writer(target)
    kerf, least_web = not_negative("kerf", kerf, "m"), positive("least_web", least_web, "m")
    chosen = style or Style()
    names = [specimen.layer(name).name for name in layers or specimen.layer_names]
    files = cut_file_names(target, names)
    at = stretch or specimen.prestretch.milestones[-1]
    bonded_marks = registration_marks(specimen.outline.polygon) if marks else []
    written = []
    for name, own in zip(names, files, strict=True):
        part = part_of(specimen, name, at)
        path_of_tool = tool_path(part.region, kerf)
        crosses = [line @ part.relaxation.T for line in bonded_marks]
        with whole_file(own, "cut file") as file:
            write(file, path_of_tool, crosses, chosen)
        length = sum(shapely.Polygon(ring).length for ring in path_of_tool)
        found = tuple(obstacles(part.region, least_web, kerf))
        written.append(CutFile(own, part, length, found))
    return written


def cut_file_names(path: str | Path, layers: Sequence[str]) -> list[Path]:
    """Return the names of the files of some layers."""
    target = Path(path)
    return [
        target if len(layers) == 1 else target.with_stem(f"{target.stem}-{name}") for name in layers
    ]


def check_cut_output(path: str | Path, inputs: Iterable[str | Path] = ()) -> None:
    """Raise InputError unless a cut file can be written: before it is drawn.

    Parameters
    ----------
    path : path-like
        Where it shall be.
    inputs : iterable of path-like
        Files that are read and must not be lost.
    """
    check_writable(path, inputs)
    check_cut_ending(path)


def check_cut_ending(path: str | Path) -> None:
    """Raise InputError unless the ending of a name is that of a format for cutters."""
    _writer(Path(path))


def _writer(path: Path) -> Callable[[Path, Lines, Lines, Style], None]:
    writers = {".dxf": _write_dxf, ".svg": _write_svg, ".pdf": _write_pdf}
    ending = path.suffix.lower()
    if ending not in writers:
        raise InputError(f"cut file {path}: expected a name in {', '.join(writers)}")
    return writers[ending]


def _write_dxf(file: Path, cuts: Lines, marks: Lines, style: Style) -> None:
    ezdxf = package("ezdxf")
    document = ezdxf.new("R2010", units=ezdxf.units.MM)
    space = document.modelspace()
    for name, colour, lines, closed in _layers(cuts, marks, style):
        if lines:
            layer = document.layers.add(name, true_color=int(colour[1:], 16))
            layer.dxf.lineweight = 0  # the thinnest there is
        for line in lines:
            space.add_lwpolyline(line / MM, close=closed, dxfattribs={"layer": name})
    document.saveas(file)


def _write_svg(file: Path, cuts: Lines, marks: Lines, style: Style) -> None:
    x, y, width, height = _page(cuts, marks)
    text = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" '
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="{width:.6g}mm" height="{height:.6g}mm" '
        f'viewBox="{x:.6g} {-y - height:.6g} {width:.6g} {height:.6g}">',
    ]
    for name, colour, lines, closed in _layers(cuts, marks, style):
        text.append(
            f'<g inkscape:groupmode="layer" inkscape:label="{name}" id="{name}" fill="none" '
            f'stroke="{colour}" stroke-width="{HAIRLINE / MM:g}">'
        )
        for line in lines:
            points = " L ".join(f"{px:.7g},{-py:.7g}" for px, py in line / MM)
            text.append(f'<path d="M {points}{" Z" if closed else ""}"/>')
        text.append("</g>")
    file.write_text("\n".join([*text, "</svg>", ""]), encoding="utf-8")


def _write_pdf(file: Path, cuts: Lines, marks: Lines, style: Style) -> None:
    from matplotlib.figure import Figure  # slow to load
    from matplotlib.patches import Polygon

    x, y, width, height = _page(cuts, marks)
    figure = Figure(figsize=(width / 25.4, height / 25.4))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(x, x + width), ylim=(y, y + height))
    axes.set_axis_off()
    points = HAIRLINE / 0.0254 * 72
    for _, colour, lines, closed in _layers(cuts, marks, style):
        for line in lines:
            outline = Polygon(line / MM, closed=closed, fill=False, ec=colour, lw=points)
            axes.add_patch(outline)
    figure.savefig(file, format="pdf", metadata={"CreationDate": None})


def _layers(cuts: Lines, marks: Lines, style: Style) -> list[tuple[str, str, Lines, bool]]:
    """Return name, colour and lines of each layer, and whether the lines are closed."""
    return [
        (style.marks, style.marks_colour, marks, False),
        (style.cut, style.cut_colour, cuts, True),
    ]


def _page(cuts: Lines, marks: Lines) -> tuple[float, float, float, float]:
    """Return the lower left corner of everything, its width and height, mm, with a margin."""
    points = np.concatenate([*cuts, *marks])
    low, high = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    (x, y), (width, height) = low / MM, (high - low) / MM
    return float(x), float(y), float(width), float(height)
