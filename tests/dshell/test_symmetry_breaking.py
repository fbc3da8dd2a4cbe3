"""If a round or many-armed specimen loses its symmetry, the stable shape is found."""

from dataclasses import replace

import numpy as np
import pytest

from bilayer import MeshSize, paper_specimen, solve
from dshell import MorleySettings

THRESHOLD = 1.0075  # of the uncut disc
FEW = 80  # iterations: none of the convex relative's crawl, which takes hundreds


def released(strips, milestones, size, branch="lowest"):
    paper = paper_specimen()
    cut = replace(paper.layer("kirigami").pattern, strips=strips) if strips else None
    specimen = replace(paper.with_layer("kirigami", pattern=cut), mesh=MeshSize(size))
    specimen = specimen.with_milestones(milestones)
    result = solve(specimen, "dshell", MorleySettings(branch=branch))
    assert result.attrs["stop_reason"] == ""
    assert not result.unstable_modes.values.any()
    return result


def extents_ratio(result):
    """Longer over shorter principal extent at each milestone, over that of the flat mesh.

    The largest two singular values do not mind about which axis the disc rolls up.
    """
    shapes = np.concatenate([result.reference_position.values[None], result.position.values])
    extents = np.linalg.svd(shapes - shapes.mean(axis=1, keepdims=True), compute_uv=False)
    ratio = extents[:, 0] / extents[:, 1]
    return ratio[1:] / ratio[0]


def test_uncut_disc_goes_from_a_cap_to_a_cylinder():
    result = released(0, [1.005, 1.007, 1.008, 1.01, 1.03], 0.008)
    round_cap = result.prestretch.values < THRESHOLD
    ratio = extents_ratio(result)
    assert np.all(ratio[round_cap] < 1.001)
    assert np.all(np.diff(ratio[~round_cap]) > 0)
    assert ratio[-1] > 1.1
    assert result.iterations.values.max() < FEW


@pytest.mark.parametrize("stretch", [1.008, 1.03, 1.06])
def test_uncut_disc_in_one_step_beyond_the_loss_of_symmetry(stretch):
    result = released(0, [stretch], 0.008)
    assert extents_ratio(result)[0] > 1.002
    assert result.iterations.values[0] < FEW


def test_seven_strips_roll_up():
    result = released(7, [1.05, 1.1], 0.01)
    assert result.load_steps.values.tolist() == [1, 1]


def test_both_sides_of_an_unstable_cap_are_as_low():
    energies = [
        released(0, [1.008], 0.008, branch).energy.sum("term").item()
        for branch in ("lowest", "other")
    ]
    assert energies[0] <= energies[1] * (1 + 1e-9)
