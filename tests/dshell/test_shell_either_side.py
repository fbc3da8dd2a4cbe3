"""Shells of either orientation and with either layer stretched: mirrored, turned, flat."""

from functools import cache

import numpy as np
import pytest

from bilayer import InputError, solve
from bilayer.geometry.alignment import rms_distance
from bilayer.mesh.planar import flat_surface
from bilayer.specimen.two_layers import turned_over, with_stretched
from dshell import HingeSettings, MorleySettings, PaperSettings
from dshell.models.morley import MorleyModel, specimen_layers

MODELS = [MorleySettings(tolerance=1e-11), HingeSettings(tolerance=1e-11)]
names = pytest.mark.parametrize("settings", MODELS, ids=["morley", "hinge"])
STRETCH = (1.05, 1.03)


def bilayer_with(specimen, layers, side):
    """The specimen with other layers stretched and the kirigami on a side."""
    stretched = with_stretched(specimen, layers)
    return stretched if side == "above" else turned_over(stretched)


@pytest.fixture(scope="module")
def released(coarse_specimen, coarse_mesh):
    """Release the coarse specimen with some layers stretched and the kirigami on a side, once."""

    @cache
    def release(settings, layers=("substrate",), side="above", **thicknesses):
        specimen = bilayer_with(coarse_specimen.with_milestones([STRETCH]), layers, side)
        for name, thickness in thicknesses.items():
            specimen = specimen.with_layer(name, thickness=thickness)
        return solve(specimen, "dshell", settings, mesh=coarse_mesh)

    return release


def apex_over_rim(result, mesh):
    height = result.position.values[0, :, 2]
    return height[mesh.centre_node] - height[mesh.rim_nodes].mean()


@names
@pytest.mark.parametrize("layers", [("substrate",), ("kirigami",)], ids=str)
def test_the_kirigami_below_gives_the_mirror_image(released, coarse_mesh, settings, layers):
    above, below = (released(settings, layers, side) for side in ("above", "below"))
    mirrored = above.position.values[0] * [1, 1, -1]
    weights = flat_surface(coarse_mesh).node_areas
    assert rms_distance(below.position.values[0], mirrored, weights) < 1e-8 * 0.04
    for name in ("quality", "sphere_radius", "height"):
        assert below[name].values == pytest.approx(above[name].values, rel=1e-8)
    assert below.self_contact_gap.values == pytest.approx(above.self_contact_gap.values)
    assert below.unstable_modes.values.tolist() == [0]


@names
def test_the_stretched_layer_is_the_inner_side(released, coarse_mesh, settings):
    """It shrinks: the dome opens downward where that is the lower layer, upward where the upper."""
    opens = {
        (layer, side): apex_over_rim(released(settings, (layer,), side), coarse_mesh)
        for layer in ("substrate", "kirigami")
        for side in ("above", "below")
    }
    assert min(opens["substrate", "above"], opens["kirigami", "below"]) > 5e-3
    assert max(opens["substrate", "below"], opens["kirigami", "above"]) < -5e-3


@names
@pytest.mark.parametrize("side", ["above", "below"])
def test_both_layers_stretched_alike_stay_flat_and_shrink(released, coarse_mesh, settings, side):
    position = released(settings, ("substrate", "kirigami"), side).position.values[0]
    shrunk = np.pad(coarse_mesh.points / STRETCH, ((0, 0), (0, 1)))
    assert rms_distance(position, shrunk, flat_surface(coarse_mesh).node_areas) < 1e-9 * 0.04


@pytest.mark.parametrize("side", ["above", "below"])
@pytest.mark.parametrize("layers", [("substrate",), ("kirigami",)], ids=str)
def test_the_layers_meet_at_the_bond(coarse_specimen, coarse_mesh, side, layers):
    specimen = bilayer_with(coarse_specimen, layers, side)
    lower, upper = specimen_layers(specimen, coarse_mesh, STRETCH)
    bond = MorleyModel(specimen, coarse_mesh, MorleySettings()).reference_height(STRETCH)
    assert lower.top == upper.bottom == pytest.approx(bond)


@pytest.mark.parametrize("side", ["above", "below"])
def test_a_thin_layer_of_either_kind_bends_little(released, coarse_mesh, side):
    """The curvature of a laminate vanishes with the thickness of either layer."""
    for name in ("substrate", "kirigami"):
        result = released(MorleySettings(), (name,), side, **{name: 1e-6})
        assert abs(apex_over_rim(result, coarse_mesh)) < 5e-4


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"side": "below"}, r"kirigami\.side = 'below': the paper's model .*expected 'above'"),
        ({"layers": ("kirigami",)}, r"prestretch\.layers = \['kirigami'\]: .*\['substrate'\]"),
    ],
)
def test_what_the_paper_has_not_is_refused_by_its_model(released, changes, message):
    with pytest.raises(InputError, match=message):
        released(PaperSettings(), **changes)
