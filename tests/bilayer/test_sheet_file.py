"""The long form of a specimen file, and quantities with units in both forms."""

import math
import re
import subprocess
import sys
from dataclasses import replace

import pytest
from sheets import EXAMPLE_SPECIMENS, EXAMPLES, OUTLINES, PATTERNS, bilayer, trilayer

from bilayer import (
    CutPattern,
    Disc,
    InputError,
    MeshSize,
    Prestretch,
    Response,
    paper_specimen,
    parse_specimen,
    read_specimen,
    specimen_to_toml,
)
from bilayer.specimen.toml import template

LOTUS = EXAMPLES / "trilayer_lotus.toml"
RADIUS = 'outer_radius = "20 mm"'


def with_everything(outline, lower, upper):
    sheet = trilayer(outline, lower, upper, mesh=MeshSize(0.002, 0.001), gravity=9.81, name="a")
    sheet = sheet.with_layer("lower", response=Response("path", factor=0.3, angle=0.7))
    sheet = sheet.with_layer("upper", response=Response("fixed", (1.1, 1.05), angle=0.2))
    return replace(sheet, prestretch=Prestretch((1.1, (1.2, 1.0), 1.1), "constant"))


@pytest.mark.parametrize("outline", OUTLINES)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_what_is_written_reads_back_the_same(outline, pattern):
    sheet = with_everything(OUTLINES[outline], PATTERNS[pattern], PATTERNS["cross"])
    assert parse_specimen(specimen_to_toml(sheet)) == sheet
    two = bilayer(OUTLINES[outline], PATTERNS[pattern])
    assert parse_specimen(specimen_to_toml(two)) == two


def test_the_short_form_is_written_for_what_it_can_express_alone():
    assert "[substrate]" in specimen_to_toml(bilayer(pattern=CutPattern(5, 0.006, 0.4)))
    for other in (
        bilayer(OUTLINES["ellipse"]),
        bilayer(pattern=PATTERNS["cross"]),
        trilayer(),
        bilayer().with_layer("kirigami", response=Response("fixed", (1.1, 1.1))),
        bilayer().with_layer("substrate", response=Response()),
        bilayer().with_layer("substrate", name="base"),
    ):
        assert "[substrate]" not in specimen_to_toml(other)
        assert parse_specimen(specimen_to_toml(other)) == other


PAPER_AS_LAYERS = """
    [specimen]
    name = "paper"
    outer_radius = "4 cm"
    [[layers]]
    name = "substrate"
    thickness = "1 mm"
    material = "tape"
    response = "path"
    [[layers]]
    name = "kirigami"
    thickness = 0.001
    material = "print"
    pattern = "strips"
    [patterns.strips]
    kind = "sectors"
    strips = 5
    inner_radius = "8 mm"
    cutout_angle = "0.3 rad"
    [materials.tape]
    young_modulus = "116.25 kPa"
    c01_over_c10 = 3.004
    poisson_ratio = 0.49
    density = "0.96 g/cm^3"
    [materials.print]
    young_modulus = "0.368988 MPa"
    c01_over_c10 = 3.004
    poisson_ratio = 0.49
    [prestretch]
    milestones = [1.03, 1.06, 1.09, 1.12, 1.15, 1.18, 1.21, 1.24]
"""


def test_the_papers_specimen_in_the_long_form_is_the_same_specimen():
    assert parse_specimen(PAPER_AS_LAYERS) == paper_specimen()


def test_units_in_the_short_form_and_in_overrides():
    text = template().replace("outer_radius = 0.04 ", 'outer_radius = "40 mm" ')
    assert parse_specimen(text) == paper_specimen()
    overrides = ["cut.cutout_angle=17.2 deg", "mesh.size='4 mm'", "substrate.density=1 g/cm3",
                 "gravity.acceleration=981 cm/s2", "kirigami.young_modulus=0.2 MPa"]  # fmt: skip
    specimen = parse_specimen(template(), overrides)
    kirigami = specimen.layer("kirigami")
    assert kirigami.pattern.cutout_angle == pytest.approx(math.radians(17.2), rel=1e-15)
    assert (specimen.mesh.size, specimen.layer("substrate").density) == (0.004, 1000.0)
    assert specimen.gravity == 9.81
    assert kirigami.material.young_modulus == pytest.approx(2e5)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("cut.inner_radius=8 kPa", "cut.inner_radius = '8 kPa': expected a length, .* '40 mm'"),
        ("cut.inner_radius=8 m**(9**9**9)", "cut.inner_radius = .*: expected a length"),
        ("cut.inner_radius=8 m^9^9^9^9^9", "cut.inner_radius = .*: expected a length"),
        (f"cut.inner_radius=8 m{'*m' * 3000}", "cut.inner_radius = .*: expected a length"),
        ("cut.inner_radius=8 m^2", "cut.inner_radius = '8 m^2': expected a length"),
        ("cut.inner_radius='8'", "cut.inner_radius = '8': expected a length"),
        ("cut.inner_radius=8 foo", "cut.inner_radius = '8 foo': expected a length"),
        ("cut.inner_radius=8 m ((", r"cut.inner_radius = '8 m \(\(': expected a length"),
        ("cut.inner_radius=nan m", "cut.inner_radius = 'nan m': expected a length"),
        ("cut.inner_radius=-8 mm", "cut.inner_radius = -0.008 m: expected a number greater"),
        ("cut.cutout_angle=30 %", "cut.cutout_angle = '30 %': expected an angle"),
        ("cut.cutout_angle=3 mm", "cut.cutout_angle = '3 mm': expected an angle"),
        ("substrate.young_modulus=3 m", "substrate.young_modulus = '3 m': expected a modulus"),
        ("substrate.density=1 kg", "substrate.density = '1 kg': expected a density"),
        ("gravity.acceleration=9.81 m/s", "gravity.acceleration = .*expected an acceleration"),
        ("cut.strips=5 mm", "cut.strips = '5 mm': expected a number"),
        ("substrate.poisson_ratio='0.4 m'", "poisson_ratio = '0.4 m': expected a number"),
    ],
)
def test_a_wrong_dimension_is_one_line(override, message):
    with pytest.raises(InputError, match=message.replace("^", r"\^")) as caught:
        parse_specimen(template(), [override])
    assert "\n" not in str(caught.value)


def test_pint_is_loaded_for_a_unit_alone():
    """It takes a tenth of a second."""
    program = (
        "import sys; from bilayer import paper_specimen, parse_specimen; paper_specimen(); "
        "print('pint' in sys.modules); from bilayer.specimen.toml import template; "
        "parse_specimen(template(), ['mesh.size=4 mm']); print('pint' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["False", "True"]


@pytest.mark.parametrize("radius", ["40", "4e-5"])
def test_a_size_that_may_be_in_another_unit_is_asked_for(tmp_path, radius):
    path = tmp_path / "s.toml"
    path.write_text(
        template().split("[cut]")[0] + "[substrate]" + template().split("[substrate]")[1]
    )
    others = [f"mesh.size={float(radius) / 9}"]
    others += [f"{layer}.thickness={float(radius) / 40}" for layer in ("substrate", "kirigami")]
    with pytest.raises(InputError, match=r"is in metres: is that meant\?.* a unit"):
        read_specimen(path, [f"specimen.outer_radius={radius}", *others])
    meant = read_specimen(path, [f"specimen.outer_radius='{radius} m'", *others])
    assert meant.characteristic_length == float(radius)
    assert parse_specimen(specimen_to_toml(meant)) == meant  # a result is not asked about


def test_a_size_with_one_unit_forgotten_is_asked_for():
    square = EXAMPLES / "square_cross.toml"
    with pytest.raises(InputError, match=r"is that meant\?.* a unit with each length"):
        read_specimen(square, ["specimen.outline.width=60"])
    assert read_specimen(square, ["specimen.outline.width=0.06"]).outline.width == 0.06


def test_a_single_value_of_a_layer_a_pattern_or_a_material_is_replaced():
    overrides = [
        "layers.upper.thickness=2 mm",
        "patterns.lotus.strips=8",
        "materials.kirigami.c10='20 kPa'",
        "layers.lower.response={kind='fixed', stretch=1.1}",
    ]
    sheet = read_specimen(LOTUS, overrides)  # fmt: skip
    upper, lower = sheet.layer("upper"), sheet.layer("lower")
    assert (upper.thickness, upper.pattern.strips, upper.material.c10) == (0.002, 8, 20_000.0)
    assert lower.response == Response("fixed", (1.1, 1.1))
    wide = ["specimen.outline.width=50 mm"]
    assert read_specimen(EXAMPLES / "square_cross.toml", wide).outline.width == 0.05


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("layers.uper.thickness=1", "layers.uper: not in this specimen file, .*mean 'upper'"),
        ("layers.upper.colour=3", "layers.upper.colour: unknown key"),
        ("layers.upper.pattern=lotos", r"pattern = 'lotos': expected one of \[patterns.lotus\]"),
        ("layers.upper.material=clay", r"material = 'clay': .*\[materials.kirigami\]"),
        ("layers.upper.response=pth", "layers.upper.response.kind = 'pth': .*mean 'path'"),
        ("layers.upper.response={factor=2}", "layers.upper.response.kind: missing"),
        ("layers.substrate.response.factor=2", "response = 'path': expected a table"),
        ("layers.upper.name=substrate", "layers: 'substrate' is the name of two"),
        ("layers.upper.thickness=0", "layers.upper.thickness = 0 m: expected"),
        ("patterns.lotus.inner_radius=30 mm", "pattern.inner_radius = 0.03 m: expected less"),
        ("patterns.lotus.kind=stars", "patterns.lotus.kind = 'stars': expected one of"),
        ("patterns.lotus.petals=10", "patterns.lotus.petals: unknown key"),
        ("patterns.lily.strips=10", "patterns.lily: not in this .*mean 'lotus'|one of lotus"),
        ("materials.kirigami.law=rubber", "materials.kirigami.law = 'rubber': expected one of"),
        ("materials.kirigami.colour=1", "materials.kirigami.colour: unknown key"),
        ("materials.kirigami.density=0", "density = 0 kg/m3: expected"),
        ("cut.strips=5", r"\[cut\]: not together with \[\[layers\]\]"),
        ("prestretch.layers=['upper']", r"prestretch.layers: expected response = 'path'"),
        ("specimen.outline={shape='disc'}", "specimen.outer_radius: not together with"),
        ("layers.upper=3", "override 'layers.upper=3': expected layers.upper.key=value"),
    ],
)
def test_bad_values_of_the_long_form_are_named(override, message):
    with pytest.raises(InputError, match=message) as caught:
        read_specimen(LOTUS, [override])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((RADIUS, "outline = { shape = \"star\" }"), "shape = 'star': expected"),
        ((RADIUS, "outline = { shape = \"ellipse\", width = 1 }"),
         "specimen.outline.height: missing"),
        ((RADIUS, "outline = 3"), "specimen.outline = 3: expected a table"),
        ((RADIUS, "outline = { shape = \"disc\", radius = 1 }"),
         "specimen.outline.shape = 'disc': expected specimen.outer_radius alone"),
        (("name = \"lower\"", ""), r"layers\[0\].name: missing"),
        (("material = \"substrate\"", ""), "layers.substrate.material: missing"),
        (("[[layers]]", "[layer]"), r"\[layer\]|layer"),
        (("[materials.substrate]", "[stuff]"), r"\[stuff\]: unknown table"),
    ],
)  # fmt: skip
def test_bad_files_of_the_long_form_are_named(change, message):
    text = LOTUS.read_text(encoding="utf-8").replace(*change)
    with pytest.raises(InputError, match=message) as caught:
        parse_specimen(text)
    assert re.fullmatch(r"[^\n]+", str(caught.value))


def test_what_belongs_to_layers_needs_layers():
    with pytest.raises(InputError, match=r"\[patterns\]: expected together with \[\[layers\]\]"):
        parse_specimen(template() + "\n[patterns.x]\nkind = 'cross'\n")
    with pytest.raises(InputError, match=r"specimen.outline: expected together with"):
        parse_specimen(template().replace("outer_radius = 0.04", "outline = { shape = 'ellipse' }"))


@pytest.mark.parametrize("path", EXAMPLE_SPECIMENS, ids=lambda path: path.stem)
def test_the_examples_are_specimens(path):
    sheet = read_specimen(path)
    assert parse_specimen(specimen_to_toml(sheet)) == sheet


def test_the_lotus_is_as_it_says():
    sheet = read_specimen(LOTUS)
    cut = sheet.layer("upper").pattern
    assert sheet.outline == Disc(0.02)
    assert sheet.layer_names == ("lower", "substrate", "upper")
    assert cut.inner_radius == pytest.approx(0.55 * 0.02)
    assert cut.strips * cut.cutout_angle == pytest.approx(0.4 * 2 * math.pi)
    assert sheet.layer("lower").material.c01 == pytest.approx(4.723 * 17_880.0, rel=1e-3)
