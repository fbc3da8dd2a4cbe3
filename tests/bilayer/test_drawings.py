"""Drawings read into contours: areas and moments of closed forms, and places of what is wrong."""

import itertools
import math
import time
from pathlib import Path

import numpy as np
import pytest
import shapely
from sheets import drawn_sheet

import bilayer
from bilayer.drawings.contours import even_odd
from bilayer.drawings.image import ImageSource
from bilayer.drawings.source import DrawingSource
from bilayer.errors import InputError

ezdxf = pytest.importorskip("ezdxf")
pytest.importorskip("svgelements")

MM = 1e-3
SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" '
    'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
    'xmlns:xlink="http://www.w3.org/1999/xlink" {size}>{content}</svg>'
)
PAGE = 'width="100mm" height="80mm" viewBox="0 0 100 80"'


def moments(region: shapely.Geometry) -> np.ndarray:
    """Area, first moments and second moments about the origin, in units of mm."""
    total = np.zeros(6)
    for piece in getattr(region, "geoms", [region]):
        oriented = shapely.geometry.polygon.orient(piece)
        for edge in (oriented.exterior, *oriented.interiors):
            x, y = np.asarray(edge.coords)[:, :2].T / MM
            cross = x[:-1] * y[1:] - x[1:] * y[:-1]
            sx, sy = x[:-1] + x[1:], y[:-1] + y[1:]
            xx = x[:-1] ** 2 + x[:-1] * x[1:] + x[1:] ** 2
            yy = y[:-1] ** 2 + y[:-1] * y[1:] + y[1:] ** 2
            xy = 2 * (x[:-1] * y[:-1] + x[1:] * y[1:]) + x[:-1] * y[1:] + x[1:] * y[:-1]
            parts = [cross / 2, cross * sx / 6, cross * sy / 6]
            parts += [cross * xx / 12, cross * yy / 12, cross * xy / 24]
            total += [part.sum() for part in parts]
    return total


def ellipse(x: float, y: float, a: float, b: float, angle: float = 0.0) -> np.ndarray:
    """The same moments of an ellipse, by closed form."""
    c, s = math.cos(angle), math.sin(angle)
    area = math.pi * a * b
    own_xx, own_yy = (a * c) ** 2 + (b * s) ** 2, (a * s) ** 2 + (b * c) ** 2
    own_xy = (a * a - b * b) * c * s
    return area * np.array(
        [1, x, y, own_xx / 4 + x * x, own_yy / 4 + y * y, own_xy / 4 + x * y], dtype=float
    )


def box(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    """The same moments of a rectangle."""
    w, h = x1 - x0, y1 - y0
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    return w * h * np.array([1, x, y, w * w / 12 + x * x, h * h / 12 + y * y, x * y])


def dxf(path: Path, version: str, unit: int, draw) -> Path:
    document = ezdxf.new(version)
    document.header["$INSUNITS"] = unit
    document.layers.add("cut", color=1)
    document.layers.add("outline", color=3)
    draw(document, document.modelspace())
    document.saveas(path)
    return path


def svg(path: Path, content: str, size: str = PAGE) -> Path:
    path.write_text(SVG.format(size=size, content=content), encoding="utf-8")
    return path


ON_CUT = {"layer": "cut"}


def dxf_circle(document, space):
    space.add_circle((12, -5), 7, dxfattribs=ON_CUT)


def dxf_bulges(document, space):
    # a stadium: two lines of 20 mm, two half circles of radius 5 mm
    points = [(0, 0, 0), (20, 0, 1), (20, 10, 0), (0, 10, 1)]
    space.add_lwpolyline(points, format="xyb", close=True, dxfattribs=ON_CUT)


def dxf_old_polyline(document, space):
    space.add_polyline2d([(0, 0), (30, 0), (30, 10), (0, 10)], close=True, dxfattribs=ON_CUT)


def dxf_blocks(document, space):
    inner = document.blocks.new("hole")
    inner.add_circle((2, 0), 3)  # on layer "0": on that of the insert
    outer = document.blocks.new("pair")
    outer.add_blockref("hole", (10, 0), dxfattribs={"xscale": 2, "yscale": 1})
    space.add_blockref("pair", (5, 5), dxfattribs={**ON_CUT, "rotation": 90})


def dxf_ellipse(document, space):
    axis = 8 * np.array([math.cos(0.5), math.sin(0.5), 0])
    space.add_ellipse((1, 2), major_axis=axis, ratio=0.4, dxfattribs=ON_CUT)


def dxf_arcs_and_lines(document, space):
    # half a disc: an arc, drawn in its mirrored frame, and a line, ends 0.2 um apart
    space.add_arc(
        (0, 0), 10, 0, 180, dxfattribs={**ON_CUT, "extrusion": (0, 0, -1)}
    )  # seen from below: x is turned
    space.add_line((-10.0002, 0), (10, 0), dxfattribs=ON_CUT)


def dxf_spline(document, space):
    # a parabola y = 4 - x^2 as a Bezier curve of degree 2, closed by a line
    spline = space.add_spline(degree=2, dxfattribs=ON_CUT)
    spline.control_points = [(-2, 0, 0), (0, 8, 0), (2, 0, 0)]
    spline.knots = [0, 0, 0, 1, 1, 1]
    space.add_line((-2, 0), (2, 0), dxfattribs=ON_CUT)


HALF_DISC = np.array(
    [math.pi * 50, 0, 2000 / 3, math.pi * 1e4 / 8, math.pi * 1e4 / 8, 0], dtype=float
)
STADIUM = box(0, 0, 20, 10) + np.array(
    [25 * math.pi, 250 * math.pi, 125 * math.pi, np.nan, np.nan, 1250 * math.pi]
)
PARABOLA = np.array([32 / 3, 0, 256 / 15, 128 / 15, 4096 / 105, 0])
INCH = 25.4 ** np.array([2, 3, 3, 4, 4, 4])

DXF = {
    "circle, R12, mm": ("R12", 4, dxf_circle, ellipse(12, -5, 7, 7)),
    "circle, 2018, inches": ("R2018", 1, dxf_circle, INCH * ellipse(12, -5, 7, 7)),
    "bulges": ("R2018", 4, dxf_bulges, STADIUM),
    "old polyline": ("R12", 5, dxf_old_polyline, box(0, 0, 300, 100)),
    "blocks": ("R2018", 4, dxf_blocks, ellipse(5, 19, 3, 6)),
    "ellipse": ("R2018", 4, dxf_ellipse, ellipse(1, 2, 8, 3.2, 0.5)),
    "arc and line": ("R12", 4, dxf_arcs_and_lines, HALF_DISC),
    "spline": ("R2018", 4, dxf_spline, PARABOLA),
}  # fmt: skip


@pytest.mark.parametrize("name", DXF)
def test_area_and_moments_of_a_dxf_drawing(tmp_path: Path, name: str) -> None:
    version, unit, draw, expected = DXF[name]
    path = dxf(tmp_path / "drawing.dxf", version, unit, draw)
    known_unit = None if version == "R2018" else {4: MM, 5: 10 * MM}[unit]
    region = even_odd(DrawingSource(path, layer="cut", unit=known_unit).contours())
    check(moments(region), expected)


SVG_FILES = {
    "circle": (
        '<circle cx="30" cy="20" r="10" stroke="red" fill="none"/>',
        PAGE,
        ellipse(30, -20, 10, 10),
    ),
    "nested groups": (
        '<g transform="translate(10,5) scale(2)"><g transform="rotate(90)">'
        '<ellipse cx="10" cy="-8" rx="4" ry="2" stroke="red"/></g></g>',
        PAGE,
        ellipse(26, -25, 4, 8),
    ),
    "skewed": (
        '<circle cx="0" cy="0" r="5" transform="matrix(2 1 0 1 40 40)" stroke="red"/>',
        PAGE,
        # x = 2 u + 40, y upwards = -40 - u - v
        25 * math.pi * np.array(
            [2, 80, -80, 2 * (1600 + 25), 2 * (1600 + 12.5), -2 * (1600 + 12.5)]
        ),
    ),
    "path with arcs": (
        '<path d="M 20,30 h 20 a 5 5 0 0 1 0 10 h -20 a 5 5 0 0 1 0 -10 z" stroke="red"/>',
        'width="10cm" viewBox="0 0 100 80"',
        None,
    ),
    "cubic": (
        # the same parabola as a cubic curve, from (-2, 0) over (0, -4) to (2, 0), y downwards
        '<path transform="translate(50,0)" stroke="red" '
        'd="M -2,0 C -0.6666666666666666,-5.333333333333333 '
        '0.6666666666666666,-5.333333333333333 2,0 Z"/>',
        PAGE,
        PARABOLA + np.array([0, 50 * PARABOLA[0], 0, 2500 * PARABOLA[0], 0, 50 * PARABOLA[2]]),
    ),
    "use and defs": (
        '<defs><rect id="r" width="10" height="5"/></defs>'
        '<use xlink:href="#r" x="20" y="10" stroke="red"/>',
        PAGE,
        box(20, -15, 30, -10),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SVG_FILES)
def test_area_and_moments_of_an_svg_drawing(tmp_path: Path, name: str) -> None:
    content, size, expected = SVG_FILES[name]
    layer = f'<g inkscape:groupmode="layer" inkscape:label="cut">{content}</g>'
    path = svg(tmp_path / "drawing.svg", layer, size)
    got = moments(even_odd(DrawingSource(path, layer="cut").contours()))
    if expected is None:
        assert got[0] == pytest.approx(200 + 25 * math.pi, rel=1e-6)
        return
    check(got, expected)


def check(got: np.ndarray, expected: np.ndarray) -> None:
    known = ~np.isnan(expected)
    scale = np.maximum(np.abs(expected), np.nanmax(np.abs(expected[1:3]), initial=1e-9))
    assert np.all(np.abs(got - expected)[known] <= 1e-6 * scale[known] + 1e-6)


def test_nested_contours_are_holes_and_islands(tmp_path: Path) -> None:
    rings = "".join(f'<circle cx="40" cy="40" r="{r}" stroke="red"/>' for r in (30, 20, 10))
    region = even_odd(DrawingSource(svg(tmp_path / "rings.svg", rings)).contours())
    assert region.area == pytest.approx(math.pi * (900 - 400 + 100) * 1e-6, rel=1e-6)


def test_layers_and_colours_choose(tmp_path: Path) -> None:
    def draw(document, space):
        space.add_circle((0, 0), 5, dxfattribs=ON_CUT)
        space.add_circle((0, 0), 9, dxfattribs={"layer": "outline"})
        space.add_circle((20, 0), 2, dxfattribs={"layer": "outline", "color": 5})
        space.add_text("cut here", dxfattribs=ON_CUT)

    path = dxf(tmp_path / "layers.dxf", "R2018", 4, draw)
    counts = {
        "red": len(DrawingSource(path, colour="red").contours()),
        "outline": len(DrawingSource(path, layer="outline").contours()),
        "blue outline": len(DrawingSource(path, layer="outline", colour="#0000ff").contours()),
        "all": len(DrawingSource(path).contours()),
    }
    assert counts == {"red": 1, "outline": 2, "blue outline": 1, "all": 3}
    with pytest.raises(
        InputError, match=r"layer = 'out': nothing is drawn there, expected one of cut, outline"
    ):
        DrawingSource(path, layer="out").contours()
    with pytest.raises(InputError, match=r"colour = 'pink': nothing is drawn in it, .*#ff0000"):
        DrawingSource(path, colour="pink").contours()


@pytest.mark.parametrize(
    ("size", "told", "radius"),
    [
        ('width="10in" height="8in" viewBox="0 0 20 16"', {}, 12.7),
        ('width="300" height="200" viewBox="0 0 300 200"', {"unit": 25.4e-3 / 96}, 25.4 / 96),
        ('width="100%" height="100%"', {"unit": 1e-3}, 1.0),
        (PAGE, {"unit": 2e-3}, 2.0),
    ],
)
def test_the_unit_of_an_svg_drawing(tmp_path: Path, size: str, told: dict, radius: float) -> None:
    path = svg(tmp_path / "unit.svg", '<circle cx="0" cy="0" r="1" stroke="red"/>', size)
    region = even_odd(DrawingSource(path, **told).contours())
    assert region.area == pytest.approx(math.pi * (radius * MM) ** 2, rel=1e-6)


@pytest.mark.parametrize("size", ['width="300" height="200" viewBox="0 0 300 200"', ""])
def test_a_unit_that_the_file_does_not_say_is_asked_for(tmp_path: Path, size: str) -> None:
    path = svg(tmp_path / "px.svg", '<circle r="1" stroke="red"/>', size)
    with pytest.raises(InputError, match=r"unit: missing, .*unit = 'mm'.*dpi = 96"):
        DrawingSource(path).contours()


NOT_SEEN = {
    "fill and stroke none": '<rect width="50" height="50" fill="none" stroke="none"/>',
    "none by a style sheet": '<style>.n{fill:none}</style><rect class="n" width="9" height="9"/>',
    "hidden": '<g visibility="hidden"><circle r="40" stroke="red"/></g>',
    "mask": '<mask id="m"><rect width="50" height="50"/></mask>',
    "marker": '<marker id="m"><path d="M0,0 L5,5 L0,5 z"/></marker>',
    "symbol that is not used": '<symbol id="s"><rect width="50" height="50"/></symbol>',
}


@pytest.mark.parametrize("name", NOT_SEEN)
def test_what_nobody_sees_is_left_out(tmp_path: Path, name: str) -> None:
    seen = '<rect x="1" y="2" width="10" height="10" stroke="red"/>'
    path = svg(tmp_path / "seen.svg", seen + NOT_SEEN[name])
    region = even_odd(DrawingSource(path).contours())
    check(moments(region), box(1, -12, 11, -2))


@pytest.mark.parametrize(
    ("content", "size", "expected"),
    [
        (
            '<symbol id="c"><rect width="5" height="5" stroke="red"/></symbol>'
            '<use xlink:href="#c" x="3" y="3"/>',
            PAGE,
            box(3, -8, 8, -3),
        ),
        ('<rect width="50%" height="25%" stroke="red"/>', PAGE, box(0, -20, 50, 0)),
        (
            '<svg x="10" y="10" width="40" height="40" viewBox="0 0 20 20">'
            '<rect width="10" height="10" stroke="red"/></svg>',
            PAGE,
            box(10, -30, 30, -10),
        ),
        (
            '<rect width="10" height="10" stroke="red"/>',
            'width="100mm" height="100mm" viewBox="0 0 100 50"',
            box(0, -10, 10, 0),
        ),
        (  # a symbol of Illustrator
            '<symbol id="s" viewBox="0 0 10 10"><rect width="10" height="5" stroke="red"/></symbol>'
            '<use xlink:href="#s" x="10" y="20" width="20" height="20"/>',
            PAGE,
            box(10, -30, 30, -20),
        ),
        (
            '<rect width="10mm" height="5mm" stroke="red"/>',
            f'width="100mm" height="80mm" viewBox="0 0 {9600 / 25.4!r} {7680 / 25.4!r}"',
            box(0, -5, 10, 0),
        ),
    ],
)
def test_what_is_drawn_by_way_of_something_else(tmp_path, content, size, expected) -> None:
    path = svg(tmp_path / "way.svg", content, size)
    check(moments(even_odd(DrawingSource(path).contours())), expected)


@pytest.mark.parametrize(
    ("content", "size", "words"),
    [
        ('<rect width="1em" height="5"/>', PAGE, r"width = '1em' of a rect: expected a number"),
        (
            '<rect width="5" height="5"/>',
            'width="100mm" height="100mm" viewBox="0 0 100 50" preserveAspectRatio="none"',
            "unit: missing, the file's preserveAspectRatio gives x and y other scales",
        ),
        (
            '<rect width="5" height="5" transform="rotate(45)" transform-origin="15 15"/>',
            PAGE,
            r"'.*no.svg': transform-origin = '15 15' of a rect: expected transforms about the",
        ),
    ],
)
def test_lengths_that_an_svg_drawing_does_not_say(tmp_path, content, size, words) -> None:
    with pytest.raises(InputError, match=words):
        DrawingSource(svg(tmp_path / "no.svg", content, size)).contours()


def dxf_with_more(document, space):
    """A circle on layer CUT; beside it what is not seen, and a surface on another layer."""
    space.add_circle((0, 0), 1, dxfattribs={"layer": "CUT"})
    space.add_circle((0, 0), 5, dxfattribs={"layer": "CUT", "invisible": 1})
    space.add_circle((9, 0), 3, dxfattribs={"layer": "help"})
    document.layers.add("help").off()
    space.add_solid([(0, 0), (1, 0), (0, 1)], dxfattribs={"layer": "frame"})


def test_layers_of_a_dxf_drawing_that_are_off_or_named_in_small_letters(tmp_path: Path) -> None:
    document = ezdxf.new("R2018")
    document.header["$INSUNITS"] = 4
    dxf_with_more(document, document.modelspace())
    document.saveas(path := tmp_path / "more.dxf")
    with pytest.raises(InputError, match="has a SOLID on layer 'frame'"):
        DrawingSource(path).contours()
    # by its name a layer that is off is read, too, and so is what is invisible
    assert len(DrawingSource(path, layer="cut").contours()) == 2
    check(moments(even_odd(DrawingSource(path, layer="help").contours())), ellipse(9, 0, 3, 3))


def smoothed(document, space):
    """A triangle, with the frame of the spline that it was smoothed by."""
    line = space.add_polyline2d([(0, 0), (10, 0), (10, 5), (20, 20), (30, 30)], close=True)
    line.dxf.flags |= 4
    for vertex in line.vertices:
        vertex.dxf.flags |= 8 if vertex.dxf.location.x < 15 else 16


def with_dots(document, space):
    """A triangle whose corner has a line without length, and what is no cut beside it."""
    ends = [(0, 0), (10, 0), (10, 0), (10, 5), (0, 0)]
    for start, end in itertools.pairwise(ends):
        space.add_line(start, end)
    space.add_wipeout([(0, 0), (50, 50)])
    space.add_underlay(document.add_underlay_def("plan.pdf"))


def with_a_frozen_block(document, space):
    """A triangle, and a block whose own layer is seen but whose insert's is not."""
    space.add_lwpolyline([(0, 0), (10, 0), (10, 5)], close=True)
    document.layers.add("frame").freeze()
    document.blocks.new("border").add_circle((0, 0), 99, dxfattribs={"layer": "lines"})
    space.add_blockref("border", (0, 0), dxfattribs={"layer": "frame"})


@pytest.mark.parametrize("draw", [smoothed, with_dots, with_a_frozen_block])
def test_what_dxf_files_hold_beside_a_triangle(tmp_path: Path, draw) -> None:
    region = even_odd(DrawingSource(dxf(tmp_path / "a.dxf", "R2018", 4, draw)).contours())
    assert region.area == pytest.approx(25 * MM**2, rel=1e-9)


def test_a_block_that_is_not_there_is_told(tmp_path: Path) -> None:
    def draw(document, space):
        space.add_blockref("nowhere", (0, 0), dxfattribs=ON_CUT)

    path = dxf(tmp_path / "gone.dxf", "R2018", 4, draw)
    with pytest.raises(InputError, match=r"cannot be read .*nowhere"):
        DrawingSource(path).contours()


@pytest.mark.parametrize("name", ["cut_x20_1", "cut_x0020_1"])
def test_names_of_illustrator_and_coreldraw_are_as_they_were_written(tmp_path, name) -> None:
    path = svg(tmp_path / "i.svg", f'<g id="{name}"><circle r="1" stroke="red"/></g>')
    assert len(DrawingSource(path, layer="Cut 1").contours()) == 1


@pytest.mark.parametrize("off", ['style="display:none"', 'display="none"'])
def test_a_hidden_layer_is_read_by_its_name_alone(tmp_path: Path, off: str) -> None:
    hidden = f'<g {off} inkscape:label="old"><circle cx="9" r="1" stroke="red"/></g>'
    path = svg(tmp_path / "h.svg", hidden + '<rect width="5" height="5" stroke="red"/>')
    check(moments(even_odd(DrawingSource(path).contours())), box(0, -5, 5, 0))
    check(moments(even_odd(DrawingSource(path, layer="old").contours())), ellipse(9, 0, 1, 1))


def test_many_contours_take_no_longer_than_their_number() -> None:
    turn = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    rings = [ring + np.array([3 * (k % 50), 3 * (k // 50)]) for k in range(2000)]
    begin = time.process_time()
    region = even_odd([*rings, *(radius * ring + [75, 60] for radius in (60, 59))])
    assert time.process_time() - begin < 5  # one after the other: 60 s
    assert not region.is_empty and region.is_valid


def test_many_holes_are_read_in_the_time_that_a_drawing_has(tmp_path: Path) -> None:
    """Within an outline of many points; each pair compared point by point took 5 s."""

    def draw(document, space):
        space.add_circle((0, 0), 200, dxfattribs=ON_CUT)
        for k in range(400):
            space.add_circle((6 * (k % 20 - 10), 6 * (k // 20 - 10)), 1.2, dxfattribs=ON_CUT)

    path = dxf(tmp_path / "holes.dxf", "R2018", 4, draw)
    begin = time.process_time()
    rings = DrawingSource(path).contours()
    assert time.process_time() - begin < 2.5
    area = math.pi * (200**2 - 400 * 1.2**2) * MM**2
    assert even_odd(rings).area == pytest.approx(area, rel=1e-6)


BAD = {
    "open": (
        "M 10,20 L 30,20 L 30,30",
        r"open contour: it ends at \(10, 20\) mm.*or slit = the width",
    ),
    "crossing itself": (
        "M 10,10 L 20,20 L 20,10 L 10,20 Z",
        r"a contour crosses itself at \(15, 15\) mm",
    ),
    "twice": (
        "M 10,10 h 5 v 5 h -5 Z M 15,10 v 5 h -5 v -5 z",
        r"a contour is drawn twice, at \(10, 10\) mm",
    ),
    "one across another": (
        "M 10,10 h 10 v 10 h -10 Z M 15,15 h 10 v 10 h -10 z",
        r"two contours cross at \((20, 15|15, 20)\) mm",
    ),
    "three ends": (
        "M 10,10 L 20,10 M 20,10 L 10,20 M 10,20 L 10,10 M 10,10 L 0,0",
        r"3 lines meet at \(10, 10\) mm",
    ),
    "line twice": (
        "M 10,10 L 20,10 M 20,10 L 10,20 M 10,20 L 10,10 M 20,10 L 10,10",
        r"a line is drawn twice, at \((20|10), 10\) mm",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_in_a_drawing_is_told_with_its_place(tmp_path: Path, name: str) -> None:
    path_data, words = BAD[name]
    path = svg(tmp_path / "bad.svg", f'<path d="{path_data}" stroke="red" fill="none"/>')
    with pytest.raises(InputError, match=words):
        DrawingSource(path).contours()


PETALS = (
    '<g id="rim"><circle cx="40" cy="40" r="30" stroke="green" fill="none"/></g>'
    '<g id="cut"><path d="M 50,40 Q 60,30 75,40 Q 60,50 50,40 Z" stroke="red" fill="none"/></g>'
)


def test_lines_that_close_nothing_are_slits_where_they_have_a_width(tmp_path: Path) -> None:
    star = "M 10,50 L 90,50 M 50,10 L 50,90"  # two slits that cross
    corner = "M 10,10 h 20 v 10"
    square = "M 60,60 h 10 v 10 h -10 z M 65,65 h 20"  # a slit that leaves a hole
    joined = "M 20,70 h 10 M 30,70 v 10 M 30,80 L 20,70"  # three lines that close a contour
    data = " ".join((star, corner, square, joined))
    path = svg(tmp_path / "slits.svg", f'<path d="{data}" stroke="red" fill="none"/>')
    region = even_odd(DrawingSource(path, slit=1 * MM).contours())
    expected = (80 + 80 - 1) + (20 + 10) + (100 + 15) + 50
    assert region.area / MM**2 == pytest.approx(expected, abs=1e-6)
    with pytest.raises(InputError, match="open contour"):
        DrawingSource(path).contours()


def test_a_slit_is_cut_into_the_sheet(tmp_path: Path) -> None:
    svg(tmp_path / "s.svg", '<path d="M 50,40 h 15" stroke="red" fill="none"/>')
    pattern = '{ drawing = "s.svg", origin = ["50 mm", "-40 mm"], slit = "1 mm" }'
    specimen = bilayer.read_specimen(drawn_sheet(tmp_path, pattern))
    whole, kept = specimen.outline.polygon.area, specimen.region_of("kirigami").area
    assert (whole - kept) / MM**2 == pytest.approx(15, rel=1e-6)


def test_a_specimen_holds_its_drawings(tmp_path: Path) -> None:
    svg(tmp_path / "petals.svg", PETALS, 'width="80mm" height="80mm" viewBox="0 0 80 80"')
    pattern = '{ drawing = "petals.svg", layer = "cut", origin = ["40 mm", "-40 mm"] }'
    outline = 'outline = { drawing = "petals.svg", layer = "rim", origin = ["40 mm", "-40 mm"] }'
    specimen = bilayer.read_specimen(drawn_sheet(tmp_path, pattern, outline))
    (tmp_path / "petals.svg").unlink()
    assert bilayer.parse_specimen(bilayer.specimen_to_toml(specimen)) == specimen
    assert specimen.outline.area == pytest.approx(math.pi * 0.03**2, rel=1e-6)
    # the cut runs over the rim: what lies beyond it does not count
    cut = specimen.outline.polygon.area - specimen.region_of("kirigami").area
    assert 0.5 * 25 * 10 * 2 / 3 < 1e6 * cut < 25 * 10 * 2 / 3
    mesh = bilayer.generate_mesh(specimen)
    bare = np.setdiff1d(np.arange(len(mesh.triangles)), mesh.faces_of("kirigami"))
    assert mesh.areas[bare].sum() == pytest.approx(cut, rel=5e-2)


def test_a_cut_outside_of_the_sheet_is_told_with_its_place(tmp_path: Path) -> None:
    svg(tmp_path / "far.svg", '<circle cx="70" cy="5" r="2" stroke="red"/>')
    path = drawn_sheet(tmp_path, '{ drawing = "far.svg" }')
    with pytest.raises(InputError, match=r"outside of the sheet, around \(70, -5\) mm"):
        bilayer.read_specimen(path)


def test_a_cut_that_overruns_the_rim_is_cut_off_there(tmp_path: Path) -> None:
    """A little is a matter of course, more is told, and much is another unit or origin."""
    told: list[str] = []

    def read(length: int) -> bilayer.Specimen:
        cut = f'<rect x="20" y="-3" width="{length}" height="4" stroke="red"/>'
        svg(tmp_path / "cut.svg", cut)
        pattern = '{ drawing = "cut.svg" }'
        return bilayer.read_specimen(drawn_sheet(tmp_path, pattern), notice=told.append)

    kept = read(22).region_of("kirigami")
    assert not told
    assert shapely.symmetric_difference(read(40).region_of("kirigami"), kept).area < 1e-12
    assert told == [
        "layers[1].pattern: what is drawn reaches 20.1 mm beyond the sheet, to (60, 3) mm from its "
        "origin; it is cut off at the rim"
    ]
    words = r"reaches 100 mm beyond the sheet, to \(140, 3\) mm from its origin; expected it on"
    with pytest.raises(InputError, match=words):
        read(120)


@pytest.mark.parametrize(
    ("pattern", "words"),
    [
        ('{ drawing = "none.svg" }', "none.svg.*No such file"),
        ('{ drawing = "petals.pdf" }', r"petals.pdf'?: expected a file in .dxf or .svg"),
        ('{ drawing = "petals.svg", layr = "cut" }', "layr: unknown key.*'layer'"),
        ('{ drawing = "petals.svg", what = "gone" }', "what = 'gone'"),
        ('{ drawing = "petals.svg", unit = "kg" }', "unit = '1 kg': expected a length"),
        ('{ drawing = "petals.svg", unit = "mm", dpi = 72 }', "dpi: not together with unit"),
        ('{ drawing = "petals.svg", origin = "top" }', "origin = 'top'"),
        ('{ drawing = "petals.svg", kerf = -1 }', "kerf = -1"),
        ('{ drawing = "petals.svg", slit = 0 }', "slit = 0"),
    ],
)
def test_a_wrong_table_of_a_drawing_is_told(tmp_path: Path, pattern: str, words: str) -> None:
    svg(tmp_path / "petals.svg", PETALS)
    (tmp_path / "petals.pdf").write_bytes(b"%PDF")
    with pytest.raises(InputError, match=words):
        bilayer.read_specimen(drawn_sheet(tmp_path, pattern))


def test_a_text_from_elsewhere_names_no_drawing(tmp_path: Path) -> None:
    svg(tmp_path / "petals.svg", PETALS)
    text = drawn_sheet(tmp_path, f'{{ drawing = "{tmp_path}/petals.svg" }}').read_text()
    with pytest.raises(InputError, match=r"drawing = .*: expected in a specimen file alone"):
        bilayer.parse_specimen(text)


@pytest.mark.parametrize("content", [b"", b"<svg", b"<html/>", b"\x00\xff", b"0\nSECTION\n"])
@pytest.mark.parametrize("ending", ["svg", "dxf"])
def test_what_is_no_drawing_is_refused(tmp_path: Path, content: bytes, ending: str) -> None:
    path = tmp_path / f"broken.{ending}"
    path.write_bytes(content)
    with pytest.raises(InputError, match="drawing"):
        DrawingSource(path, unit=1e-3).contours()


@pytest.mark.parametrize(("kind", "white"), [("u1", 255), ("u2", 65535), ("f4", 1), ("i4", 65535)])
def test_images_of_any_depth_have_the_same_shades(tmp_path: Path, kind: str, white: float) -> None:
    """Pillow cuts off what is deeper than 8 bits at 255 when it is asked for another mode."""
    image = pytest.importorskip("PIL.Image")
    y, x = np.mgrid[:60, :80]
    dark = (x - 40) ** 2 + (y - 30) ** 2 < 20**2
    name = tmp_path / f"{kind}.tif"
    image.fromarray(np.where(dark, 0.2 * white, 0.9 * white).astype(kind)).save(name)
    (ring,), dropped = ImageSource(name, 0.08).contours()
    assert dropped == 0
    assert shapely.Polygon(ring).area == pytest.approx(1e-6 * dark.sum(), rel=0.01)


def test_an_image_of_other_numbers_than_shades_is_refused(tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    heights = np.linspace(-3.0, 5.0, 48).reshape(6, 8).astype("f4")
    image.fromarray(heights).save(tmp_path / "heights.tif")
    with pytest.raises(InputError, match=r"heights\.tif.*from -3 to 5, expected from 0 \("):
        ImageSource(tmp_path / "heights.tif", 0.08).contours()


def test_an_image_is_contoured(tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    y, x = np.mgrid[0:200, 0:200] + 0.5
    ring = (np.hypot(x - 100, y - 100) < 80) & (np.hypot(x - 100, y - 100) > 40)
    speck = np.hypot(x - 20, y - 20) < 4
    image.fromarray(np.where(ring | speck, 0, 255).astype("uint8")).save(tmp_path / "ring.png")
    pattern = '{ image = "ring.png", width = "60 mm", smoothing = "0.5 mm", least_area = "9 mm^2" }'
    told = []
    specimen = bilayer.read_specimen(drawn_sheet(tmp_path, pattern), notice=told.append)
    (line,) = told
    assert line.endswith("pattern: 1 parts and holes below least_area = 9 mm^2 dropped")
    kept = specimen.region_of("kirigami")
    assert kept.area == pytest.approx(math.pi * (0.024**2 - 0.012**2), rel=3e-3)
    assert len(specimen.layer("kirigami").pattern.contours) == 2


def test_a_pattern_from_a_geometry_of_shapely() -> None:
    ring = shapely.Point(0, 0).buffer(0.03) - shapely.Point(0, 0).buffer(0.02)
    pattern = bilayer.Pattern.from_geometry(ring)
    kept = pattern.kept(bilayer.Disc(0.04))
    assert shapely.symmetric_difference(kept, ring).area < 1e-12
    with pytest.raises(InputError, match="geometry = POINT"):
        bilayer.Pattern.from_geometry(shapely.Point(0, 0))


@pytest.mark.parametrize("path", ["Mxx yy Q", "M20 10 Z", "M20 10 L40 10 Z"])
def test_a_drawing_that_bounds_nothing_is_told(tmp_path, path):
    file = tmp_path / "nothing.svg"
    file.write_text(SVG.format(size=PAGE, content=f'<path d="{path}"/>'))
    with pytest.raises(InputError, match="expected closed contours, has none"):
        DrawingSource(file).contours()
