"""Design files, variables and scenarios."""

import math
from pathlib import Path

import numpy as np
import pytest

from bilayer import InputError, paper_specimen, read_design
from bilayer.designing.checked import milestones_to
from bilayer.designing.scenarios import Robustness, Scenario
from bilayer.designing.variables import Variable, Variables, value_of, with_values
from bilayer.designing.widths import LeastWidths
from bilayer.specimen.toml import template

FILE = """
specimen = "specimen.toml"
profile = { knots = 3 }
[target]
shape = "cap"
angle = "60 deg"
[free]
prestretch = [1.02, 1.3]
"kirigami.thickness" = ["0.5 mm", "2 mm"]
"kirigami.pattern.half_angles" = ["3 deg", "25 deg"]
[robust]
of = ["kirigami.thickness"]
spread = 0.04
[constraints]
least_web = "2 mm"
least_gap = "1 mm"
[search]
evaluations = 7
settings = { tolerance = 1e-9 }
[check]
runs = 2
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "specimen.toml").write_text(template())
    return tmp_path


def read(folder, text=FILE):
    (folder / "design.toml").write_text(text)
    return read_design(folder / "design.toml")


def test_a_file_is_read_in_si_units(folder):
    task = read(folder)
    assert task.variables.names == (
        "prestretch",
        "kirigami.thickness",
        *(f"kirigami.pattern.half_angles.{k}" for k in range(3)),
    )
    assert task.variables.variables[1].high == 2e-3
    assert task.variables.variables[2].high == pytest.approx(math.radians(25))
    assert task.specimen.prestretch.milestones == ((1.24, 1.24),)
    assert task.widths.least_web == 2e-3
    assert task.least_gap == 1e-3
    assert task.limits.evaluations == 7
    assert task.settings.tolerance == 1e-9
    assert task.check.runs == 2
    assert [each.words for each in task.robustness.scenarios] == [
        "nominal",
        "kirigami.thickness +4%",
        "kirigami.thickness -4%",
    ]


def test_the_profile_of_equal_sectors_is_the_same_sheet(folder):
    task = read(folder)
    before, after = paper_specimen(), task.specimen
    assert after.region_of("kirigami").area == pytest.approx(before.region_of("kirigami").area)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("evaluations = 7", "evaluation = 7", "did you mean 'evaluations'"),
        ("[robust]", "[robusts]", "robusts"),
        ("prestretch = [1.02, 1.3]", "prestretch = [1.3, 1.02]", "expected less"),
        ("prestretch = [1.02, 1.3]", "prestretch = 1.3", r"expected \[from, to\]"),
        ("prestretch = [1.02, 1.3]", "prestretch = [1.02, 1.2]", "the specimen has 1.24"),
        ("half_angles", "half_angle", "half_angle"),
        ('least_web = "2 mm"', 'least_web = "30 mm"', "short of them"),
        ('of = ["kirigami.thickness"]', 'of = ["kirigami.pattern.inner_radius"]', "moves the mesh"),
        ('specimen = "specimen.toml"', 'specimen = "no.toml"', "no.toml"),
        ('specimen = "specimen.toml"', "specimen = 3", "specimen = 3"),
        ("evaluations = 7", "radius = 'x'", "search.radius = 'x'"),
        ("evaluations = 7", "radius = 2", "search.radius = 2"),
        (
            "settings = { tolerance = 1e-9 }",
            "settings = 3",
            r"search.settings = 3: expected a table",
        ),
        ("runs = 2", "step = -1", "check.step = -1"),
        ('["0.5 mm", "2 mm"]', "[-1, 2]", "free.kirigami.thickness: -1 is out of its range"),
        (
            '["3 deg", "25 deg"]',
            '["-3 deg", "25 deg"]',
            "free.kirigami.pattern.half_angles.0: from",
        ),
        ('angle = "60 deg"', "radius = [1]", r"target.radius = \[1\]"),
        ('angle = "60 deg"', "radius = 1e-12", "expected less than 20 times between them"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(folder, old, new, words):
    with pytest.raises(InputError, match=words):
        read(folder, FILE.replace(old, new))


def test_other_tasks_have_other_identities(folder):
    first = read(folder).identity
    assert read(folder).identity == first
    assert read(folder, FILE.replace("2 mm", "2.1 mm")).identity != first
    assert read(folder, FILE.replace("60 deg", "61 deg")).identity != first
    assert read(folder, FILE.replace("evaluations = 7", "evaluations = 9")).identity != first
    assert read(folder, FILE.replace("runs = 2", "runs = 3")).identity == first


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("prestretch.y", 1.17),
        ("substrate.thickness", 2e-3),
        ("kirigami.modulus", 2e5),
        ("kirigami.material.c10", 2e4),
        ("kirigami.pattern.inner_radius", 0.01),
        ("kirigami.pattern.half_angles.1", 0.2),
        ("outline.radius", 0.05),
    ],
)
def test_a_number_is_what_it_was_set_to(profiled, name, value):
    changed = with_values(profiled, {name: value})
    assert value_of(changed, name) == pytest.approx(value, rel=1e-12)
    assert changed != profiled


def test_a_modulus_takes_all_constants_with_it(profiled):
    stiff = with_values(profiled, {"kirigami.modulus": 3e5}).layer("kirigami").material
    soft = profiled.layer("kirigami").material
    factor = 3e5 / soft.shear_modulus
    assert stiff.c01 == pytest.approx(factor * soft.c01)
    assert stiff.poisson_ratio == pytest.approx(soft.poisson_ratio)


@pytest.mark.parametrize("name", ["a.pattern.b", "outline.colour", "kirigami.pattern.radius",
                                  "kirigami.pattern.half_angles.9"])  # fmt: skip
def test_a_number_that_is_not_there_is_named(profiled, name):
    with pytest.raises(InputError, match=r"parameter|layer"):
        value_of(profiled, name)


def test_variables_are_shares_of_their_bounds(profiled):
    variables = Variables((Variable("prestretch", 1.0, 1.2), Variable("kirigami.modulus", 0, 1e6)))
    shares = variables.shares_of(profiled)
    assert shares[0] == pytest.approx(0.6)
    again = variables.shares_of(variables.specimen(profiled, np.array([0.1, 0.7])))
    assert again == pytest.approx([0.1, 0.7])
    with pytest.raises(InputError, match="twice"):
        Variables((Variable("prestretch", 1, 2), Variable("prestretch", 1, 3)))


@pytest.mark.parametrize("minimise", ["mean", "worst"])
def test_the_derivatives_of_what_is_minimised(minimise):
    robustness = Robustness(0.05, ("kirigami.thickness",), minimise)
    values = np.array([0.01, 0.03, 0.02])
    total, weights = robustness.total(values)
    for k, weight in enumerate(weights):
        step = 1e-7 * np.eye(3)[k]
        ahead, behind = (robustness.total(values + sign * step)[0] for sign in (1, -1))
        assert (ahead - behind) / 2e-7 == pytest.approx(weight, rel=1e-6)
    assert values.mean() <= total <= values.max()


def test_an_error_of_the_prestretch_is_one_of_its_strain(profiled):
    erring = Scenario({"prestretch": 0.05}).specimen(profiled)
    assert value_of(erring, "prestretch") == pytest.approx(1.126)


def test_widths_that_are_too_small_are_negative_and_those_at_their_least_are_named(profiled):
    assert LeastWidths(1e-3, 1e-3).margins(profiled).min() > 0
    assert LeastWidths(0.0, 5e-3).margins(profiled).min() < 0
    slot = 2 * 0.12 * 0.008
    assert LeastWidths(1e-3, slot).binding(profiled) == ["least_slot"]


def test_milestones_on_the_way_of_two_axes():
    assert milestones_to((1.2, 0.9), 0.1) == [(1.1, 0.95), (1.2, 0.9)]
    assert milestones_to((1.05, 1.05), 0.1) == [(1.05, 1.05)]


def test_the_example_is_a_design():
    task = read_design(Path(__file__).parents[3] / "examples" / "design_hemisphere.toml")
    assert len(task.variables.names) == 8
    assert task.widths.margins(task.specimen).min() > 0


def test_the_example_of_a_field_begins_with_a_half_everywhere():
    task = read_design(Path(__file__).parents[3] / "examples" / "design_field.toml")
    shares = [name for name in task.variables.names if name.startswith("kirigami.share.")]
    assert len(shares) == 21
    assert [each.specimen.layer("kirigami").pattern.sharpness for each in task.sharpened()] == [
        0.0, 6.0, 20.0,
    ]  # fmt: skip
