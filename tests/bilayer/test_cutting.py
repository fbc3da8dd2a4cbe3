"""Cut files: read back they give the pattern, and what cannot be made is named."""

import math
import re

import numpy as np
import pytest
import shapely
from sheets import PATTERNS, circle, drawn_sheet, square

import bilayer
from bilayer import Polygons
from bilayer.cli.main import main
from bilayer.cutting.files import write_cut_files
from bilayer.cutting.obstacles import obstacles
from bilayer.cutting.part import part_of
from bilayer.cutting.tool_path import tool_path
from bilayer.drawings.contours import even_odd
from bilayer.drawings.dxf import DxfDocument
from bilayer.drawings.source import DrawingSource
from bilayer.errors import InputError
from bilayer.specimen.drawn import offset

pytest.importorskip("ezdxf")
pytest.importorskip("svgelements")


def sheet(pattern: bilayer.Pattern, response: str = "none") -> bilayer.Specimen:
    soft = bilayer.MooneyRivlin(2e4, 1e4, 1e-6)
    layers = (
        bilayer.Layer("substrate", 1e-3, soft, response=bilayer.Response("path")),
        bilayer.Layer("kirigami", 1e-3, soft, pattern=pattern, response=bilayer.Response(response)),
    )
    mesh = bilayer.MeshSize(4e-3)
    return bilayer.Specimen(bilayer.Disc(0.02), layers, bilayer.Prestretch([1.25]), mesh)


RINGS = [shapely.Point(x, 0.001).buffer(r) for x, r in ((0, 0.015), (0.003, 0.008), (0.002, 0.004))]
KINDS = PATTERNS | {
    "polygons apart": Polygons((square(0.002, 0.002, 0.005), circle(0.012, 0.006, 0.003))),
    "contours kept": bilayer.Pattern.from_geometry(RINGS[0] - RINGS[1] | RINGS[2]),
    "contours cut": bilayer.Pattern.from_geometry(RINGS[0] - RINGS[1] | RINGS[2], "cut"),
}


@pytest.mark.parametrize("ending", ["dxf", "svg"])
@pytest.mark.parametrize("kerf", [0.0, 2e-4])
@pytest.mark.parametrize("name", KINDS)
def test_a_cut_file_read_back_is_the_pattern(tmp_path, name, kerf, ending):
    specimen = sheet(KINDS[name])
    path = tmp_path / f"kirigami.{ending}"
    write_cut_files(specimen, path, ["kirigami"], kerf=kerf)
    rings = DrawingSource(path, layer="cut").contours()
    read = offset(even_odd(rings), -kerf / 2) if kerf else even_odd(rings)
    kept = specimen.region_of("kirigami")
    if kerf > 0 and name == "kept polygons":  # two that touch at a point: the kerf joins them
        assert any("loose" in place.what for place in obstacles(kept, kerf, 0.0))
        return
    # cutouts that begin as a point are narrower than the kerf there
    nearest = 1e-6 if kerf == 0 or name != "pointed profile" else 2e-5
    assert shapely.hausdorff_distance(read.boundary, kept.boundary) < nearest
    assert read.area == pytest.approx(kept.area, abs=10 * nearest * 1e-3)


def test_a_specimen_from_its_own_cut_file(tmp_path):
    """Through the specimen file, kerf and all."""
    specimen = bilayer.paper_specimen()
    write_cut_files(specimen, tmp_path / "kirigami.dxf", ["kirigami"], kerf=2e-4)
    pattern = '{ drawing = "kirigami.dxf", layer = "cut", what = "kept", kerf = "0.2 mm" }'
    read = bilayer.read_specimen(drawn_sheet(tmp_path, pattern)).region_of("kirigami")
    kept = specimen.region_of("kirigami")
    assert shapely.hausdorff_distance(read.boundary, kept.boundary) < 1e-6


@pytest.mark.parametrize("ending", ["dxf", "svg"])
def test_cuts_are_found_by_their_colour(tmp_path, ending):
    write_cut_files(sheet(PATTERNS["cross"]), tmp_path / f"a.{ending}", ["kirigami"], marks=True)
    assert len(DrawingSource(tmp_path / f"a.{ending}", colour="red").contours()) == 1


def test_a_stretched_layer_is_cut_smaller(tmp_path):
    specimen = sheet(PATTERNS["sectors"], response="path")
    part = part_of(specimen, "kirigami", (1.25, 1.0))
    x, y, far_x, far_y = specimen.region_of("kirigami").bounds
    assert part.size == pytest.approx(((far_x - x) / 1.25, far_y - y))
    assert part.stretched_size == pytest.approx((far_x - x, far_y - y))
    assert part.region.area == pytest.approx(specimen.region_of("kirigami").area / 1.25)
    turned = bilayer.Response("fixed", (1.25, 1.0), angle=math.pi / 2)
    part = part_of(specimen.with_layer("kirigami", response=turned), "kirigami", (1.0, 1.0))
    assert part.size == pytest.approx((far_x - x, (far_y - y) / 1.25))


def test_marks_of_a_stretched_layer_lie_over_the_others_when_it_is_stretched(tmp_path):
    files = write_cut_files(sheet(None), tmp_path / "a.dxf", marks=True)
    lower, upper = (
        [line.points for line in DxfDocument(file.path).lines(1e-3) if line.layers == ("marks",)]
        for file in files
    )
    assert len(lower) == len(upper) == 6
    assert np.allclose(1.25 * np.array(lower), np.array(upper))


def test_inner_cuts_come_first():
    rings = [shapely.Point(0, 0).buffer(r) for r in (0.04, 0.03, 0.02, 0.01)]
    region = (rings[0] - rings[1]) | (rings[2] - rings[3])
    sizes = [np.ptp(ring[:, 0]) / 2 for ring in tool_path(region, 0.0)]
    assert sizes == pytest.approx([0.01, 0.02, 0.03, 0.04])


def test_lines_are_hairlines(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    write_cut_files(bilayer.paper_specimen(), tmp_path / "a.dxf", ["kirigami"])
    layer = ezdxf.readfile(tmp_path / "a.dxf").layers.get("cut")
    assert layer.dxf.lineweight == 0
    write_cut_files(bilayer.paper_specimen(), tmp_path / "a.svg", ["kirigami"])
    assert 'stroke-width="0.01"' in (tmp_path / "a.svg").read_text()


def test_the_tool_runs_half_a_kerf_outside():
    path = tool_path(shapely.box(0, 0, 0.01, 0.01), 2e-4)
    assert shapely.Polygon(path[0]).bounds == pytest.approx((-1e-4, -1e-4, 0.0101, 0.0101))


SQUARE = shapely.box(0, 0, 0.02, 0.02)
OBSTACLES = {
    "nothing": (SQUARE, 1e-3, 0.0, []),
    "sharp corners": (shapely.Polygon([(0, 0), (0.02, 0), (0, 0.005)]), 1e-3, 0.0, []),
    "loose": (
        SQUARE | shapely.box(0.03, 0, 0.035, 0.004), 1e-3, 0.0,
        [r"loose piece of 20 mm2 at \(32.5, 2\) mm"],
    ),
    "web": (
        SQUARE - shapely.box(0.0005, 0.005, 0.015, 0.01), 1e-3, 0.0,
        [r"web of 0.5 mm at \(0.25, .*\) mm"],
    ),
    "slot": (
        SQUARE - shapely.box(0.005, 0.005, 0.0057, 0.015), 1e-3, 0.0,
        [r"slot of 0.7 mm at \(5.35, .*\) mm"],
    ),
    "slot to the rim": (
        SQUARE - shapely.box(0.01, 0.0, 0.0107, 0.015), 1e-3, 0.0,
        [r"slot of 0.7 mm at \(10.35, .*\) mm"],
    ),
    "tongue": (
        SQUARE | shapely.box(0.02, 0.01, 0.03, 0.0106), 1e-3, 0.0,
        [r"web of 0.6 mm at \(.*, 10.3\) mm"],
    ),
    "inner corners": (
        SQUARE - shapely.box(0.005, 0.005, 0.015, 0.015), 1e-3, 4e-4,
        [r"4 inner corners stay rounded to the kerf's radius of 0.2 mm"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", OBSTACLES)
def test_what_cannot_be_made_is_named_with_its_place(name):
    region, least_web, kerf, expected = OBSTACLES[name]
    found = [str(obstacle) for obstacle in obstacles(region, least_web, kerf)]
    assert len(found) == len(expected), found
    for text, words in zip(found, expected, strict=True):
        assert re.search(words, text), text


def test_the_papers_sheet_has_no_obstacle():
    region = bilayer.paper_specimen().region_of("kirigami")
    assert obstacles(region, 1e-3, 0.0) == []


def test_the_verb(tmp_path, capsys):
    (tmp_path / "paper.toml").write_text(bilayer.specimen_to_toml(bilayer.paper_specimen()))
    words = [f"{tmp_path}/paper.toml", "-o", f"{tmp_path}/parts.svg", "--prestretch", "1.25"]
    assert main(["cut", *words, "--marks", "--style", "ponoko", "--colour", "green"]) == 0
    out = capsys.readouterr().out
    assert "parts-substrate.svg: substrate, 64 x 64 mm, to be stretched to 80 x 80 mm" in out
    text = (tmp_path / "parts-kirigami.svg").read_text()
    assert 'inkscape:label="cut"' in text and 'stroke="#008000"' in text
    assert text.count("<path") == 1 + 6
    assert main(["cut", *words, "--layer", "kirigami", "--least-web", "8 mm"]) == 0
    printed = capsys.readouterr()
    assert "parts.svg: kirigami, " in printed.out and "web of" in printed.err


def test_a_pdf_is_in_true_size(tmp_path):
    write_cut_files(bilayer.paper_specimen(), tmp_path / "a.pdf", ["kirigami"])
    box = re.search(rb"MediaBox \[ ?0 0 ([\d.]+) ([\d.]+)", (tmp_path / "a.pdf").read_bytes())
    width = bilayer.paper_specimen().region_of("kirigami").bounds
    expected = ((width[2] - width[0]) * 1e3 + 4) / 25.4 * 72
    assert float(box[1]) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-o", "a.txt"], "cut file a.txt: expected a name in .dxf, .svg, .pdf"),
        (["-o", "a.dxf", "--layer", "kirigamy"], "layer = 'kirigamy'.*did you mean 'kirigami'"),
        (["-o", "a.dxf", "--kerf", "2 s"], "cut.kerf = '2 s': expected a length"),
        (["-o", "a.dxf", "--kerf=-1 mm"], "kerf = -0.001"),
        (["-o", "a.dxf", "--colour", "reddish"], "colour = 'reddish'"),
        (["-o", "a.dxf", "--prestretch", "1,06"], "decimal point"),
    ],
)
def test_wrong_words_are_told(tmp_path, monkeypatch, capsys, words, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "paper.toml").write_text(bilayer.specimen_to_toml(bilayer.paper_specimen()))
    assert main(["cut", "paper.toml", *words]) == 2
    assert re.search(message, capsys.readouterr().err)
    assert [file.name for file in tmp_path.iterdir()] == ["paper.toml"]


def test_a_kerf_that_leaves_nothing_to_cut_is_told():
    with pytest.raises(InputError, match="kerf"):
        write_cut_files(bilayer.paper_specimen(), "a.dxf", kerf=-1)
