"""The specimen as TOML: round trips, overrides, errors."""

import tomllib

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bilayer import (
    CutPattern,
    Disc,
    InputError,
    Layer,
    LinearElastic,
    MeshSize,
    MooneyRivlin,
    NeoHookean,
    Prestretch,
    disc_bilayer,
    paper_specimen,
    parse_specimen,
    read_specimen,
    specimen_to_toml,
)
from bilayer.specimen.toml import specimen_from_tables, template

length = st.floats(1e-5, 1e-2)
modulus = st.floats(1.0, 1e7)
poisson = st.floats(0.0, 0.5)
law = st.one_of(
    st.builds(MooneyRivlin.from_moduli, modulus, poisson, st.floats(0.0, 10.0)),
    st.builds(NeoHookean.from_moduli, modulus, poisson),
    st.builds(LinearElastic, modulus, poisson),
)
layer = st.builds(Layer, st.just("layer"), length, law, st.floats(1.0, 5000.0))
cut = st.one_of(
    st.none(),
    st.builds(CutPattern, st.integers(1, 12), st.floats(0.001, 0.03), st.floats(0.01, 0.5)),
)
pair = st.tuples(st.floats(0.5, 1.5), st.floats(0.5, 1.5))
path = st.lists(st.one_of(st.floats(0.5, 1.5), pair), min_size=1, max_size=4, unique_by=str).map(
    lambda items: sorted(items, key=lambda item: max(item) if isinstance(item, tuple) else item)
)


@st.composite
def specimens(draw):
    items = draw(path)
    nominal = [max(item) if isinstance(item, tuple) else item for item in items]
    unique = [item for k, item in enumerate(items) if nominal.index(nominal[k]) == k]
    layers = draw(st.sampled_from([["substrate"], ["kirigami"], ["kirigami", "substrate"]]))
    prestretch = Prestretch(unique, draw(st.sampled_from(["natural", "constant"])))
    mesh = draw(st.sampled_from([MeshSize(), MeshSize(0.003, 0.001)]))
    side = draw(st.sampled_from(["above", "below"]))
    return disc_bilayer(
        0.04, draw(layer), draw(layer), prestretch, draw(cut), mesh, draw(st.floats(0, 10)), "a",
        side, layers,
    )  # fmt: skip


@settings(suppress_health_check=[HealthCheck.too_slow], deadline=None)  # on a busy machine
@given(specimens())
def test_what_is_written_reads_back_the_same(specimen):
    assert parse_specimen(specimen_to_toml(specimen)) == specimen


def test_the_template_is_the_papers_specimen():
    specimen = paper_specimen()
    assert (specimen.outline, specimen.characteristic_length) == (Disc(0.04), 0.04)
    assert specimen.layer("kirigami").pattern == CutPattern(5, 0.008, 0.3)
    assert specimen.layer("kirigami").material.young_modulus == pytest.approx(368_988.0)
    assert specimen.prestretch.nominal == [1.03, 1.06, 1.09, 1.12, 1.15, 1.18, 1.21, 1.24]


@pytest.mark.parametrize("unit", ["m", "rad", "Pa", "kg/m3", "m/s2"])
def test_the_template_names_the_units(unit):
    assert f"# {unit}" in template()


def test_overrides_replace_single_keys():
    specimen = parse_specimen(template(), ["cut.strips=6", "substrate.thickness = 0.0008"])
    assert specimen.layer("kirigami").pattern.strips == 6
    assert specimen.layer("substrate").thickness == 0.0008


def test_without_the_cut_table_the_disc_is_whole():
    text = template().split("[cut]")[0] + "[substrate]" + template().split("[substrate]")[1]
    assert parse_specimen(text).layer("kirigami").is_whole


def test_constants_may_be_given_directly():
    text = """
        [specimen]
        outer_radius = 0.04
        [substrate]
        thickness = 0.001
        c10 = 4839.1
        c01 = 14536.0
        d1 = 0.0
        [kirigami]
        thickness = 0.001
        law = "linear"
        young_modulus = 1e5
        poisson_ratio = 0.5
        [prestretch]
        milestones = [1.03]
    """
    specimen = parse_specimen(text)
    assert specimen.layer_names == ("substrate", "kirigami")
    assert specimen.stretched_layers == ("substrate",)
    assert specimen.layer("substrate").material == MooneyRivlin(4839.1, 14_536.0, 0.0)
    assert specimen.layer("kirigami").material == LinearElastic(1e5, 0.5)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("cut.strips=0", r"cut.strips = 0: leave the \[cut\] table out"),
        ("cut.strips=2.5", "cut.strips = 2.5: expected a whole number"),
        ("cut.strips='five'", "cut.strips = 'five': expected a number"),
        ("cut.strip=3", "cut.strip: unknown key, .*did you mean 'strips'"),
        ("cuts.strips=3", "unknown table 'cuts'; did you mean 'cut'"),
        ("cut.cutout_angle=1.4", r"cutout_angle = 1.4 rad: 5 cutouts need less than 2\*pi/5"),
        ("cut.cutout_angle=0", "cut.cutout_angle = 0 rad: expected a number greater than 0"),
        ("cut.inner_radius=0.04", "cut.inner_radius = 0.04 m: expected less than"),
        ("cut.inner_radius=inf", "cut.inner_radius = inf: expected a finite number"),
        ("specimen.outer_radius=nan", "specimen.outer_radius = nan: expected a finite"),
        ("specimen.outer_radius=true", "specimen.outer_radius = True: expected a number"),
        ("specimen.name=3", "specimen.name = 3: expected a text"),
        ("substrate.thickness=-1", "substrate.thickness = -1 m: expected a number greater"),
        ("substrate.young_modulus=0", "substrate.young_modulus = 0 Pa: expected"),
        ("substrate.poisson_ratio=0.6", "substrate.poisson_ratio = 0.6: expected from 0 to 0.5"),
        ("substrate.law=lineer", "substrate.law = 'lineer': .*did you mean 'linear'"),
        ("substrate.law=linear", "substrate.c01_over_c10: not a constant of law = 'linear'"),
        ("substrate.c10=3", "substrate.c10: given together with young_modulus"),
        ("kirigami.density=0", "kirigami.density = 0 kg/m3"),
        ("prestretch.milestones=abc", "prestretch.milestones = 'abc': expected a list"),
        ("prestretch.layers=kirigami", "prestretch.layers = 'kirigami': expected a list"),
        ("prestretch.layers=['lid']", "prestretch.layers = 'lid': expected one of 'substrate'"),
        ("prestretch.layers=[3]", "prestretch.layers = 3: expected one of 'substrate'"),
        ("kirigami.side=under", "kirigami.side = 'under': expected one of 'above', 'below'"),
        ("kirigami.side=[1]", r"kirigami.side = \[1\]: expected one of 'above', 'below'"),
        ("substrate.side=above", "substrate.side: unknown key"),
        ("prestretch.thickness=thin", "prestretch.thickness = 'thin': expected one of 'natural'"),
        ("gravity.acceleration=-9.81", "gravity.acceleration = -9.81 m/s2"),
        ("mesh.size=0", "mesh.size = 0 m"),
        ("mesh.size=0.05", "mesh.size = 0.05 m: expected at most specimen.outer_radius"),
        ("mesh.size='1,5 mm'", r"expected a length, .*'40 mm', with a decimal point"),
        ("mesh.corner_size=0.005", "mesh.corner_size = 0.005 m: expected at most mesh.size"),
        ("mesh", "override 'mesh': expected table.key=value"),
    ],
)
def test_bad_values_are_named(override, message):
    with pytest.raises(InputError, match=message):
        parse_specimen(template(), [override])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[specimen", "not a valid TOML file"),
        ("[cut]\nx = 0,3", r"line 2, .*expected a decimal point, not a comma"),
        ("[vary]\n'cut.strips' = 4, 5", r"if two values are meant, brackets: \[4, 5\]"),
        ("[cut]\ninner radius = 0.008", "expected a key without spaces, such as inner_radius"),
        ("[kirigami]\nside = above  # it", 'expected quotes around a text: "above"'),
        ("x = 1 mm", r'expected quotes around a value with a unit: "1 mm"'),
        ("", "^specimen.outer_radius: missing"),
        ("cut = 3", r"cut = 3: expected a table \[cut\]"),
        ("[substrat]\nthickness = 1.0", r"\[substrat\]: unknown table, .*mean 'substrate'"),
        ("outer_radius = 1.0", r"\[outer_radius\]: unknown table"),
    ],
)
def test_bad_files_are_named(text, message):
    with pytest.raises(InputError, match=message):
        parse_specimen(text)


@pytest.mark.parametrize(
    ("table", "key"),
    [("cut", "strips"), ("kirigami", "thickness"), ("prestretch", "milestones")],
)
def test_missing_keys_are_named(table, key):
    tables = tomllib.loads(template())
    del tables[table][key]
    with pytest.raises(InputError, match=f"^{table}.{key}: missing"):
        specimen_from_tables(tables)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none.toml: cannot be read \(No such file"):
        read_specimen(tmp_path / "none.toml")
    binary = tmp_path / "binary.toml"
    for content, words in ((b"\x89\xff\x00", "not a text file"), (b"\xff\xfe\x00", "is UTF-16")):
        binary.write_bytes(content)
        with pytest.raises(InputError, match=words):
            read_specimen(binary)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("dome.nc", "not a result, which `bilayer info`"),
        ("petals.SVG", r"not a drawing, .*pattern = \{ drawing"),
        ("pixels.png", "not an image"),
        ("sheet.msh", "not a mesh, which `--mesh` takes"),
    ],
)
def test_a_file_of_another_kind_is_told_what_it_is_for(tmp_path, name, words):
    (tmp_path / name).write_bytes(b"\x89HDF")
    with pytest.raises(InputError, match=words):
        read_specimen(tmp_path / name)
