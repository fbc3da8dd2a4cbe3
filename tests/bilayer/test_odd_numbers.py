"""Numbers and structures that nobody expects: one line that names them, at once, and no file."""

import time
from dataclasses import replace

import numpy as np
import pytest
from made_results import cap_result
from sheets import trilayer

from bilayer import InputError, PlanarMesh, paper_specimen
from bilayer.cli.main import main
from bilayer.mesh.agreement import check_agreement
from bilayer.mesh.validity import check_covers_once
from bilayer.results.report import describe_trust
from bilayer.specimen.doubts import doubts
from bilayer.specimen.layer import Response
from bilayer.specimen.overrides import toml_value, with_overrides
from bilayer.specimen.toml import parse_specimen, parse_specimen_file, template
from bilayer.specimen.toml_text import DEEPEST, parse_toml
from bilayer.study.variation import MOST_CASES
from bilayer.validation import finite, listed, positive, shown, whole, within

DIGITS_400, DIGITS_5000 = "9" * 400, "9" * 5000
FIELDS = (
    "specimen.outer_radius", "cut.strips", "cut.cutout_angle", "substrate.thickness",
    "substrate.young_modulus", "prestretch.milestones", "gravity.acceleration", "mesh.size",
    "solver.tolerance", "solver.max_iterations", "solver.ramp", "solver.branch",
)  # fmt: skip
ODD = {
    "400 digits": DIGITS_400,
    "5000 digits": DIGITS_5000,
    "5000 digits in hex": "0x" + "f" * 5000,
    "no float": "1e400",
    "none": "nan",
    "infinite": "inf",
    "a date": "1979-05-27",
    "a list of nothing": "[[]]",
    "a deep list": "[" * 3000 + "]" * 3000,
    "a deep table": "{a=" * 3000 + "1" + "}" * 3000,
    "a table": "{a = 1}",
    "a long text": "'" + "x" * 10**6 + "'",
    "a unit of nothing": "'9e99999 m'",
    "a quantity of 5000 digits": f"'{DIGITS_5000} m'",
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(template())
    return tmp_path


def assert_refused(folder, capsys, words, *parts):
    """Assert one short line on stderr with these parts, exit status 2, at once, no new file."""
    before, start = sorted(folder.iterdir()), time.monotonic()
    try:
        status = main(words)
    except SystemExit as end:
        status = end.code
    captured = capsys.readouterr()
    assert (status, captured.out) == (2, "")
    assert captured.err.count("\n") == 1
    assert len(captured.err) < 3000
    for part in parts:
        assert part in captured.err
    assert sorted(folder.iterdir()) == before
    assert time.monotonic() - start < 20


@pytest.mark.parametrize("value", ODD.values(), ids=ODD)
@pytest.mark.parametrize("field", FIELDS)
def test_an_odd_value_of_a_field_is_refused(folder, capsys, field, value):
    if field == "solver.branch" and value.startswith("'9"):
        pytest.skip("a text as any other")
    words = ["solve", "s.toml", "--solver", "dshell", "-o", "a.nc"]
    assert_refused(folder, capsys, [*words, "--set", f"{field}={value}"])


@pytest.mark.parametrize("odd", [
    "x = " + "[" * 100_000 + "]" * 100_000,
    "x = " + "{a = " * 100_000 + "1" + "}" * 100_000,
    "[" + ".".join("a" * 100_000) + "]",
    ".".join('"a"' for _ in range(100_000)) + " = 1",
    f"x = {DIGITS_5000}",
    "x = 1\nx = 2",
    "\0",
], ids=["lists", "tables", "header", "key", "digits", "twice", "nul"])  # fmt: skip
def test_odd_toml_is_refused_at_once(odd):
    start = time.monotonic()
    with pytest.raises(InputError, match=r"^file:") as refused:
        parse_toml(odd, "file")
    assert len(str(refused.value)) < 1000
    assert time.monotonic() - start < 5


def test_a_number_of_too_many_digits_is_told_by_its_line():
    with pytest.raises(InputError, match=r"^file: line 3, x\.y: a number of 5000 digits, exp"):
        parse_toml(f"# {DIGITS_400}\n[a]\nx.y = [1, {DIGITS_5000}]\n", "file")
    with pytest.raises(InputError, match=r"^file: line 1, \"c d\": a number of 5000 digits"):
        parse_toml(f'a = [{{b = 1, "c d" = {DIGITS_5000}}}]', "file")
    with pytest.raises(InputError, match=r"^file: line 2: a number of 5000 digits"):
        parse_toml(f"a = [\n{DIGITS_5000}]", "file")


def test_a_value_of_a_field_that_is_no_toml_names_the_field():
    with pytest.raises(InputError, match=r"^cut.strips = '\[\[.* is nested too deeply"):
        with_overrides({}, ["cut.strips=" + "[" * 60 + "]" * 60], {"cut": ["strips"]})


def test_toml_as_people_write_it_is_read():
    deep = "[" * (DEEPEST - 1) + "]" * (DEEPEST - 1)
    assert parse_toml(f"x = {deep}", "file")
    assert parse_toml('text = "1.2.3.4.5.6.7.8.9.10.11.12"\n' * 1, "file")
    assert parse_toml("points = [" + "[0.1, 0.2]," * 50_000 + "]", "file")
    assert [toml_value("field", text) for text in ("0x10", "1_000", "1e3", "text", "'1 m'")] == [
        16, 1000, 1000.0, "text", "1 m",
    ]  # fmt: skip


@pytest.mark.parametrize("text", [
    template().replace("[1.03, 1.06", f"[{DIGITS_400}, 1.06"),
    template().replace("strips = 5", f"strips = {DIGITS_400}"),
    template().replace("outer_radius = 0.04 ", "outer_radius = 1e308 "),
    template().replace("outer_radius = 0.04 ", "outer_radius = 1e-320 "),
    template().replace("thickness = 0.001 ", "thickness = 1.0 ", 1),
    template().replace("thickness = 0.001 ", "thickness = '1 m' ", 1),
    template().replace("acceleration = 0.0 ", "acceleration = 1e29 "),
    template() + "\n[patterns]\nx = 1979-05-27\n",
], ids=range(8))  # fmt: skip
def test_an_odd_specimen_file_is_refused(text):
    assert text != template()
    with pytest.raises(InputError) as refused:
        parse_specimen_file(text)
    assert len(str(refused.value)) < 1000


HEAD = 'specimen = "s.toml"\nsolver = "dshell"\n'
MANY = ", ".join(str(0.001 + 1e-6 * k) for k in range(1000))


@pytest.mark.parametrize(("text", "part"), [
    ('[vary]\n"cut.strips" = {start = 1, stop = 2, num = 1e30}', "vary.cut.strips.num"),
    ('[vary]\n"cut.strips" = {start = 1, stop = 2, num = 1000000}', "vary.cut.strips.num"),
    (f'[vary]\n"cut.strips" = {{start = 1, stop = {DIGITS_400}, num = 3}}', "vary.cut.strips.stop"),
    (f'[vary]\n"cut.cutout_angle" = [{MANY}]\n"mesh.size" = [{MANY}]\n'
     f'"substrate.thickness" = [{MANY}]', f"1000000000 cases: expected at most {MOST_CASES}"),
    (f'[vary]\n"mesh.size" = [{MANY}]\n[zip]\n"substrate.thickness" = [{MANY}]', "1000000 cases"),
    ('[sample]\nn = 1e9\nseed = 1\n"cut.cutout_angle" = {low = 0.1, high = 0.2}', "sample.n"),
    ('[sample]\nn = 3\nseed = 1e30\n"cut.cutout_angle" = {low = 0.1, high = 0.2}', "sample.seed"),
    ('[vary]\n"cut.strips" = [1979-05-27]', "vary.cut.strips"),
    ('[vary]\n"cut.strips" = [[]]', "cut.strips"),
    ('[vary]\n"cut.strips" = [{a = 1}]', "vary.cut.strips"),
    ('[zip]\n"cut.strips" = [07:32:00]', "zip.cut.strips"),
    (f'[vary]\n"cut.strips" = [{DIGITS_400}]', "cut.strips"),
    ('[vary]\n"" = [1]', "table.key=value"),
    ("[settings.dshell]\ntolerance = 1979-05-27", "solver.tolerance"),
    ("[settings.dshell]\nramp = 1e-30", "solver.ramp"),
    ('x = "' + "x" * 10**6 + '"', "x: unknown"),
], ids=range(16))  # fmt: skip
def test_an_odd_study_file_is_refused_before_its_cases_are_made(folder, capsys, text, part):
    (folder / "study.toml").write_text(HEAD + text)
    assert_refused(folder, capsys, ["study", "study.toml", "-o", "out"], part)


@pytest.mark.parametrize("solver", ['[["dshell"]]', "1979-05-27", "{a = 1}"])
def test_an_odd_solver_of_a_study_is_refused(folder, capsys, solver):
    (folder / "study.toml").write_text(f'specimen = "s.toml"\nsolver = {solver}\n')
    assert_refused(folder, capsys, ["study", "study.toml", "-o", "out"], "solver = ")


@pytest.mark.parametrize("words", [
    ["study", "study.toml", "-o", ""],
    ["solve", "s.toml", "--solver", "dshell", "-o", " "],
    ["mesh", "s.toml", "-o", ""],
    ["mesh", "", "-o", "m.msh"],
    ["export", "s.toml", "-o", ""],
    ["info", ""],
    ["info", "a\0.nc"],
    ["mesh", "s.toml", "-o", "m\0.msh"],
])  # fmt: skip
def test_an_empty_name_is_refused(folder, capsys, words):
    (folder / "study.toml").write_text(HEAD)
    assert_refused(folder, capsys, words, "expected a word, not an empty one")


def test_a_nul_in_a_name_of_a_file_is_refused(folder, capsys):
    (folder / "study.toml").write_text('specimen = "s\\u0000.toml"\nsolver = "dshell"\n')
    assert_refused(folder, capsys, ["study", "study.toml", "-o", "out"], "specimen file")


@pytest.mark.parametrize("size", ["1e-9", "1e-30", "1e-320", "1e9", "'1e-9 parsec'", DIGITS_400])
def test_a_mesh_of_an_absurd_size_is_refused_before_it_is_made(folder, capsys, size):
    words = ["mesh", "s.toml", "-o", "m.msh", "--mesh-size", size]
    if "parsec" in size:  # 31 km
        words[-1] = size.strip("'")
    assert_refused(folder, capsys, words, "mesh.size")


@pytest.mark.parametrize("setting", [
    "ramp=1e-30", "ramp=5e-324", "smallest_step=1e-30", "longest_step=1e-30",
    "max_iterations=1e30", "coarse_triangles=1e30", "time_step=1e-30", "total_time=1e300",
])  # fmt: skip
def test_steps_without_end_are_refused_before_they_begin(folder, capsys, setting):
    words = ["solve", "s.toml", "--solver", "dshell", "-o", "a.nc", "--set", f"solver.{setting}"]
    assert_refused(folder, capsys, words, f"solver.{setting.partition('=')[0]}")


@pytest.mark.parametrize("setting", [
    "smallest_step=1e-30", "first_step=1e-9", "flow_steps=1e30", "iteration_limit=1e30",
    "elements=1e9", "quadrature_degree=1000",
])  # fmt: skip
def test_steps_without_end_of_the_solid_are_refused_before_they_begin(folder, capsys, setting):
    words = ["solve", "s.toml", "--solver", "fenics", "-o", "a.nc", "--set", f"solver.{setting}"]
    assert_refused(folder, capsys, words, f"solver.{setting.partition('=')[0]}")


def test_single_values():
    assert finite("x", np.float64(3)) == 3.0
    assert whole("x", 2.0, at_least=1) == 2
    assert within("x", 1, 0.5, 2) == 1.0
    for check, value in (
        (finite, 10**400), (finite, -(10**400)), (finite, 10**5000), (finite, 1e31),
        (positive, 1e-31), (positive, 5e-324), (listed, {}), (listed, "ab"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=r"^x = .*: expected "):
            check("x", value)
    with pytest.raises(InputError, match="at most 7"):
        whole("x", 8, at_least=1, at_most=7)
    assert len(shown("y" * 10**7)) < 300
    assert shown(np.float64(0.5)) == "0.5"


def annulus_wound(turns):
    """Return a ring of squares, cut in two, that goes around some turns and is not closed."""
    angle = np.linspace(0, 2 * np.pi * turns, 24 * turns + 1)[:-1]
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.concatenate([ring, 2 * ring])
    count = len(angle)
    here, there = np.arange(count - 1), np.arange(1, count)
    lower = np.column_stack([here, here + count, there + count])
    upper = np.column_stack([here, there + count, there])
    triangles = np.concatenate([lower, upper])
    return points, triangles, np.ones(len(triangles), dtype=int)


def test_a_mesh_that_is_wound_around_twice_is_refused():
    once, twice = (PlanarMesh(*annulus_wound(turns)) for turns in (1, 2))
    check_covers_once(once.points, once.triangles)
    with pytest.raises(InputError, match="covers each place once"):
        check_agreement(paper_specimen(), twice)


def test_what_is_hardly_meant_is_asked_about(folder, capsys):
    sheet = trilayer()
    flat = replace(sheet, layers=[replace(layer, response=Response()) for layer in sheet.layers])
    assert doubts(paper_specimen()) == doubts(sheet) == doubts(replace(flat, gravity=9.81)) == []
    assert [doubt.partition(",")[0] for doubt in doubts(flat)] == [
        "no layer has a response to the prestretch"
    ]
    words = ["mesh", "s.toml", "--mesh-size", "0.02", "-o", "m.msh", "--quiet"]
    assert main([*words, "--set", "prestretch.milestones=[0.15]"]) == 0
    told = capsys.readouterr().err
    assert told.startswith("bilayer: warning: prestretch 0.15: a layer is compressed")
    assert told.count("\n") == 1
    trust = describe_trust(cap_result(flat.with_milestones([1.03])))
    assert "Doubtful: no layer has a response" in trust


@pytest.mark.parametrize(
    ("changes", "doubt"),
    [
        (["substrate.thickness=0.02"], "substrate.thickness = 20 mm: the sheet has a radius of 40"),
        (
            ["prestretch.milestones=[1.5, 3]"],
            "prestretch 3: a layer is bonded at more than 2 times",
        ),
        (["prestretch.milestones=[0.15]"], "prestretch 0.15: a layer is compressed to less than"),
        (["substrate.young_modulus=116.25"], "substrate: Young's modulus of 116.2 Pa, no sheet is"),
        (
            ["kirigami.young_modulus=3e14"],
            "kirigami: Young's modulus of 3e+14 Pa, no sheet is as st",
        ),
        (["kirigami.density=0.96"], "kirigami.density = 0.96 kg/m3: no sheet is as light"),
    ],
)
def test_what_is_hardly_meant_is_asked(changes, doubt):
    (line,) = doubts(parse_specimen(template(), changes))
    assert line.startswith(doubt)


@pytest.mark.parametrize("thickness", ["9 mm", "0.01 mm"])
def test_what_may_be_meant_is_not_asked(thickness):
    changes = [f"kirigami.thickness={thickness}", "prestretch.milestones=[0.9, 1.9]",
               "substrate.young_modulus=2 kPa", "kirigami.young_modulus=200 GPa"]  # fmt: skip
    assert doubts(parse_specimen(template(), changes)) == []
