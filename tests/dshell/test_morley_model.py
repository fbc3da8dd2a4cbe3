"""The default model from a specimen to a result."""

import numpy as np
import pytest

from bilayer import solve
from bilayer.solvers import settings_kind
from dshell import MorleySettings


@pytest.fixture(scope="module")
def released(coarse_specimen, coarse_mesh):
    specimen = coarse_specimen.with_milestones([1.03, 1.15])
    return solve(specimen, "dshell", MorleySettings(), mesh=coarse_mesh)


def test_it_is_the_default_model():
    assert settings_kind("dshell") is MorleySettings


def test_milestones_are_stable_equilibria_reached_in_one_step_each(released):
    assert released.converged.values.tolist() == [1, 1]
    assert released.unstable_modes.values.tolist() == [0, 0]
    assert released.load_steps.values.tolist() == [1, 1]
    assert released.residual.values.max() <= MorleySettings().tolerance
    assert released.attrs["stop_reason"] == ""


def test_released_disc_is_a_dome_with_its_apex_up(released, coarse_mesh):
    for shape in released.position.values:
        assert shape[coarse_mesh.centre_node, 2] > shape[coarse_mesh.rim_nodes, 2].max()


def test_height_is_near_that_of_the_solid(released):
    """10.4 and 27.0 mm by the finite-element model on a mesh of 4 mm; this one is of 10 mm."""
    assert released.height.values == pytest.approx([10.4e-3, 27.0e-3], rel=0.06)


def test_energy_of_each_layer(released):
    assert set(released.term.values) == {"substrate", "kirigami"}
    assert np.all(released.energy.values > 0)
