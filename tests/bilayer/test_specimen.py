"""Values that a specimen accepts and refuses, and its description of itself."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bilayer import CutPattern, InputError, Prestretch, paper_specimen
from bilayer.specimen.two_layers import turned_over, with_stretched


def stretched(*layers, thickness="natural", side="above"):
    """The paper's specimen with other layers stretched, the kirigami on a side."""
    prestretch = replace(paper_specimen().prestretch, thickness=thickness)
    specimen = with_stretched(replace(paper_specimen(), prestretch=prestretch), layers)
    return specimen if side == "above" else turned_over(specimen)


@pytest.mark.parametrize("name", ["substrate", "kirigami"])
def test_the_layer_that_is_stretched_keeps_its_volume_or_its_thickness(name):
    natural = stretched(name).bonded_layer(name, (1.2, 1.1))
    assert natural.thickness == pytest.approx(0.001 / 1.32)
    assert natural.stretch == ((1.2, 0.0), (0.0, 1.1))
    constant = stretched(name, thickness="constant").bonded_layer(name, (1.2, 1.1))
    assert constant.thickness == 0.001
    (other,) = {"substrate", "kirigami"} - {name}
    unstretched = stretched(name).bonded_layer(other, (1.2, 1.1))
    assert (unstretched.thickness, unstretched.stretch) == (0.001, ((1.0, 0.0), (0.0, 1.0)))


def test_both_layers_may_be_stretched():
    layers = stretched("kirigami", "substrate").bonded_layers((1.2, 1.1))
    assert [part.axial_stretch for part in layers] == [(1.2, 1.1), (1.2, 1.1)]


@pytest.mark.parametrize(
    ("side", "order"),
    [("above", ["substrate", "kirigami"]), ("below", ["kirigami", "substrate"])],
)
def test_layers_are_listed_from_the_bottom_and_meet_at_the_bond(side, order):
    lower, upper = stretched("substrate", side=side).bonded_layers((1.2, 1.2))
    assert [lower.name, upper.name] == order
    assert lower.bottom < lower.top == 0 == upper.bottom < upper.top
    assert (lower.is_above, upper.is_above) == (False, True)


def test_the_cutouts_are_in_the_kirigami_layer_alone():
    sets = paper_specimen().layer_sets
    assert sets == ({"substrate"}, {"substrate", "kirigami"})


def test_other_milestones_leave_the_stretched_layers():
    specimen = stretched("kirigami", thickness="constant").with_milestones([1.5])
    assert specimen.prestretch == Prestretch((1.5,), "constant")
    assert specimen.stretched_layers == ("kirigami",)


@pytest.mark.parametrize(
    ("layers", "message"),
    [
        ("kirigami", "expected a list"),
        ([], r"prestretch.layers = \[\]: expected one or both"),
        (["substrate", "substrate"], "each once"),
        (["top"], "prestretch.layers = 'top': expected one of 'substrate', 'kirigami'"),
        (["kirigam"], "did you mean 'kirigami'"),
    ],
)
def test_bad_stretched_layers_are_named(layers, message):
    with pytest.raises(InputError, match=message):
        with_stretched(paper_specimen(), layers)


def test_first_strip_lies_on_the_x_axis():
    """Cutouts are centred at 2 pi (k + 1/2) / n."""
    assert CutPattern(5, 0.008, 0.3).cutout_centres[0] == pytest.approx(math.pi / 5)


def test_milestones_are_pairs_whatever_they_come_as():
    assert Prestretch((1.1, [1.2, 1.0])).milestones == ((1.1, 1.1), (1.2, 1.0))
    assert Prestretch(np.array([1.1, 1.2])).nominal == [1.1, 1.2]
    assert paper_specimen().with_milestones([1.5]).prestretch.nominal == [1.5]


@pytest.mark.parametrize(
    ("milestones", "message"),
    [
        ([], "expected at least one"),
        ([0.0], "prestretch.milestones = 0.0: expected a number greater than 0"),
        ([-1.1], "greater than 0"),
        ([math.inf], "finite"),
        ([[1.1, 1.2, 1.3]], r"one number or \[lambda_x, lambda_y\]"),
        ("1.1", "expected a list of numbers"),
        (1.1, "expected a list of numbers"),
    ],
)
def test_bad_milestones_are_named(milestones, message):
    with pytest.raises(InputError, match=message):
        Prestretch(milestones)
