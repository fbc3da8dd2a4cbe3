"""What a specimen accepts, refuses and says of itself."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bilayer import CutPattern, InputError, Prestretch, paper_specimen


def test_bonded_thickness_keeps_the_volume_or_the_thickness():
    natural = paper_specimen()
    assert natural.bonded_thickness((1.2, 1.1)) == pytest.approx(0.001 / 1.32)
    constant = replace(natural, prestretch=replace(natural.prestretch, thickness="constant"))
    assert constant.bonded_thickness((1.2, 1.1)) == 0.001


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
        ([1.0, 1.0], "each once, but 1.0 follows 1.0"),
        ([1.2, 1.1], "1.1 follows 1.2"),
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
