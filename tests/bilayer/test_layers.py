"""Layers of a sheet: responses to the prestretch, heights, carrier, reference surface, regions."""

import math
from dataclasses import replace

import numpy as np
import pytest
from sheets import MATERIAL, OUTLINES, PATTERNS, bilayer, trilayer

from bilayer import CutPattern, InputError, Layer, Prestretch, Response, Specimen
from bilayer.specimen.reference_surface import ReferenceSurface
from bilayer.specimen.two_layers import TwoLayers

CUT, WIDER, WIDEST = (CutPattern(5, 0.006, angle) for angle in (0.4, 0.9, 1.0))


def test_responses_are_tensors_from_the_natural_state():
    assert Response().tensor((1.2, 1.1)) == ((1.0, 0.0), (0.0, 1.0))
    assert Response("path").tensor((1.2, 1.1)) == ((1.2, 0.0), (0.0, 1.1))
    assert Response("fixed", (1.3, 0.9)).tensor((1.2, 1.1)) == ((1.3, 0.0), (0.0, 0.9))
    half = Response("path", factor=0.5).tensor((1.2, 1.1))
    assert np.array(half) == pytest.approx(np.diag([1.1, 1.05]))


def test_a_turned_response_stretches_along_its_own_axes():
    response = Response("fixed", (1.3, 0.9), angle=0.4)
    stretch = np.array(response.tensor((1.0, 1.0)))
    first, second = [math.cos(0.4), math.sin(0.4)], [-math.sin(0.4), math.cos(0.4)]
    assert stretch @ first == pytest.approx(1.3 * np.array(first))
    assert stretch @ second == pytest.approx(0.9 * np.array(second))
    assert stretch[0, 1] == stretch[1, 0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"kind": "often"}, "kind = 'often': expected one of 'none', 'path', 'fixed'"),
        ({"kind": "path", "stretch": 1.1}, r"stretch = \[1.1, 1.1\]: expected with kind = 'fixed'"),
        ({"kind": "fixed", "factor": 2.0}, "factor = 2.0: expected with kind = 'path'"),
        ({"angle": 0.1}, "angle = 0.1 rad: expected with kind"),
        ({"kind": "fixed", "stretch": (1, 2, 3)}, r"stretch = \[1, 2, 3\]: expected one number"),
        ({"kind": "fixed", "stretch": 0.0}, "stretch = 0.0: expected a number greater than 0"),
    ],
)
def test_bad_responses_are_named(options, message):
    with pytest.raises(InputError, match=message):
        Response(**options)


def test_a_factor_that_turns_a_layer_inside_out_is_refused():
    stretched = Response("path", factor=-30.0)
    with pytest.raises(InputError, match=r"factor = -30.0: makes a stretch of -0.5 of the path's"):
        bilayer().with_layer("kirigami", response=stretched)


def test_a_trilayer_is_measured_from_the_middle_of_its_stretched_layer():
    sheet = trilayer(lower=CUT, upper=CUT)
    assert (sheet.carrier.name, str(sheet.reference_surface)) == (
        "substrate",
        "middle of substrate",
    )
    lower, middle, upper = sheet.bonded_layers((1.2, 1.1))
    bonded = 1.1e-3 / 1.32
    assert (middle.bottom, middle.top) == pytest.approx((-bonded / 2, bonded / 2))
    assert (lower.top, upper.bottom) == (middle.bottom, middle.top)
    assert (lower.thickness, upper.thickness) == pytest.approx((1.6e-3, 1.6e-3))
    assert (lower.is_above, middle.is_above, upper.is_above) == (False, False, True)
    assert middle.determinant == pytest.approx(1.32)


def test_each_stretched_layer_thins_by_its_own_area_stretch():
    sheet = trilayer().with_layer("upper", response=Response("fixed", (1.1, 1.2), angle=0.3))
    layers = sheet.bonded_layers((1.5, 1.5))
    assert layers[2].thickness == pytest.approx(1.6e-3 / 1.32)
    kept = replace(sheet, prestretch=Prestretch((1.5,), "constant")).bonded_layers((1.5, 1.5))
    assert [part.thickness for part in kept] == pytest.approx([1.6e-3, 1.1e-3, 1.6e-3])


def layer(name, pattern=None, kind="none"):
    return Layer(name, 1e-3, MATERIAL, pattern=pattern, response=Response(kind))


@pytest.mark.parametrize(
    ("layers", "carrier", "surface"),
    [
        ([layer("a")], "a", "middle of a"),
        ([layer("a"), layer("b", kind="path")], "b", "top of a"),
        ([layer("a", CUT, "path"), layer("b"), layer("c", kind="fixed")], "c", "middle of c"),
        ([layer("a"), layer("b", CUT, "path"), layer("c")], "a", "middle of a"),
        ([layer("kirigami", kind="path"), layer("substrate")], "substrate", "top of kirigami"),
        ([layer("a", WIDER), layer("b", CUT), layer("c", WIDEST)],
         "b", "middle of b"),
    ],
)  # fmt: skip
def test_the_carrier_is_whole_and_stretched_if_there_is_such_a_layer(layers, carrier, surface):
    sheet = Specimen(OUTLINES["disc"], layers, Prestretch((1.1,)))
    assert sheet.carrier.name == carrier
    assert str(sheet.reference_surface) == surface
    assert ReferenceSurface.parse(surface) == sheet.reference_surface


def test_regions_are_bits_of_the_layers_that_may_be_missing():
    assert bilayer(pattern=CUT).layer_sets == ({"substrate"}, {"substrate", "kirigami"})
    assert trilayer(lower=CUT, upper=CUT).layer_sets == (
        {"substrate"}, {"substrate", "lower"}, {"substrate", "upper"},
        {"substrate", "lower", "upper"},
    )  # fmt: skip
    single = Specimen(OUTLINES["disc"], [layer("a")], Prestretch((1.1,)))
    assert single.layer_sets == ({"a"},)
    lattice = Specimen(OUTLINES["disc"], [layer("a", CUT)], Prestretch((1.1,)))
    assert lattice.layer_sets == (set(), {"a"})


@pytest.mark.parametrize(
    ("layers", "message"),
    [
        ([], "layers: there are 0, expected from 1 to 12"),
        ([layer("a"), layer("a")], "layers: 'a' is the name of two"),
        ([3], "layers: 3 is among them"),
        (["a" * 101], r"name = 'a{20}\.\.\.': has 101 letters, expected at most 100"),
        ("layers", "layers = 'layers': expected a list"),
    ],
)
def test_bad_layers_are_named(layers, message):
    with pytest.raises(InputError, match=message):
        named = [layer(one) if isinstance(one, str) else one for one in layers]
        given = layers if isinstance(layers, str) else named
        Specimen(OUTLINES["disc"], given, Prestretch((1.1,)))


def test_a_layer_is_asked_for_by_its_name():
    assert trilayer().layer("upper").name == "upper"
    with pytest.raises(InputError, match=r"layer = 'uper': expected .*did you mean 'upper'"):
        trilayer().layer("uper")
    with pytest.raises(InputError, match=r"name = 'a b': expected letters"):
        layer("a b")
    with pytest.raises(InputError, match=r"layers.upper.pattern.inner_radius = 0.03 m: expected"):
        trilayer(upper=CutPattern(5, 0.03, 0.4))


@pytest.mark.parametrize(
    ("specimen", "message"),
    [
        (trilayer(), "model = 'hinge': takes two layers named .* this specimen has 3: lower, "),
        (bilayer().with_layer("substrate", pattern=CUT), "takes a whole substrate"),
        (bilayer().with_layer("kirigami", response=Response("path", angle=0.1)),
         "stretched along x and y, expected layers.kirigami with angle = 0 instead of 0.1"),
    ],
)  # fmt: skip
def test_what_is_no_bilayer_is_refused_in_one_line(specimen, message):
    with pytest.raises(InputError, match=message) as caught:
        TwoLayers.of(specimen, "model = 'hinge'")
    assert "\n" not in str(caught.value)


def test_the_two_layers_of_any_outline_and_pattern():
    for outline in OUTLINES.values():
        two = TwoLayers.of(bilayer(outline, PATTERNS["cross"]), "a model")
        assert (two.substrate.name, two.kirigami_side) == ("substrate", "above")


def test_numbers_of_numpy_are_kept_as_plain_ones():
    sheet = replace(
        bilayer(), gravity=np.float32(1.0), prestretch=Prestretch(np.array([[1.5, 1.25]]))
    )
    assert (type(sheet.gravity), type(sheet.prestretch.milestones[0][0])) == (float, float)
    assert type(Layer("a", np.float64(1e-3), MATERIAL).thickness) is float
    assert type(CutPattern(5.0, np.float64(0.006), 0.4).strips) is int
    with pytest.raises(InputError, match=r"prestretch.milestones = 1.05: expected a list"):
        sheet.with_milestones(1.05)
    assert sheet.with_milestones([1.2, 1.1, 1.2, (1.2, 1.0)]).prestretch.nominal == [
        1.2,
        1.1,
        1.2,
        1.2,
    ]
