"""The default model from a specimen to a result."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bilayer import Gent, InputError, MeshSize, PlanarMesh, generate_mesh, solve
from bilayer.geometry.alignment import rms_distance
from bilayer.solvers.registry import settings_class
from dshell import MorleySettings


@pytest.fixture(scope="module")
def released(coarse_specimen, coarse_mesh):
    specimen = coarse_specimen.with_milestones([1.03, 1.15])
    return solve(specimen, "dshell", MorleySettings(), mesh=coarse_mesh)


def test_it_is_the_default_model():
    assert settings_class("dshell") is MorleySettings


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


def test_another_result_starts_the_first_milestone(coarse_specimen, coarse_mesh, released):
    specimen = coarse_specimen.with_milestones([1.03])
    again = solve(specimen, "dshell", MorleySettings(), mesh=coarse_mesh, start=released)
    assert again.iterations.values[0] < released.iterations.values[0]
    assert again.position.values[0] == pytest.approx(released.position.values[0], abs=1e-7)


def test_a_start_on_another_mesh_is_refused(coarse_specimen, released):
    with pytest.raises(InputError, match="expected a result on the planar mesh of this run"):
        finer = generate_mesh(replace(coarse_specimen, mesh=MeshSize(0.008)))
        solve(coarse_specimen, "dshell", MorleySettings(), mesh=finer, start=released)


def test_where_it_stops_the_last_equilibrium_is_kept(coarse_specimen, coarse_mesh):
    """Two iterations are too few for any step but from an equilibrium to itself."""
    specimen = coarse_specimen.with_milestones([1.06])
    settings = MorleySettings(max_iterations=2, smallest_step=0.2)
    result = solve(specimen, "dshell", settings, mesh=coarse_mesh)
    assert result.converged.values.tolist() == [0]
    assert np.isfinite(result.last_position.values).all()
    assert result.attrs["stop_reason"].startswith("stopped at prestretch 1: Newton's method")


def test_no_prestretch_is_flat_and_costs_nothing(coarse_specimen, coarse_mesh):
    specimen = coarse_specimen.with_milestones([1.0, 1.03])
    result = solve(specimen, "dshell", MorleySettings(), mesh=coarse_mesh)
    assert result.converged.values.tolist() == [1, 1]
    assert result.iterations.values[0] == 0
    assert np.ptp(result.position.values[0, :, 2]) < 1e-12


def test_a_compressed_substrate_bends_the_other_way(coarse_specimen, coarse_mesh):
    specimen = coarse_specimen.with_milestones([0.97])
    shape = solve(specimen, "dshell", MorleySettings(), mesh=coarse_mesh).position.values[0]
    assert shape[coarse_mesh.centre_node, 2] < shape[coarse_mesh.rim_nodes, 2].mean() - 5e-3


def test_weight_pulls_the_rim_down(coarse_specimen, coarse_mesh, released):
    specimen = replace(coarse_specimen, gravity=9.81).with_milestones([1.03])
    heavy = solve(specimen, "dshell", MorleySettings(), mesh=coarse_mesh)
    assert heavy.converged.values.tolist() == [1]
    assert heavy.position.values[0, coarse_mesh.rim_nodes, 2].mean() < -1.05 * float(
        released.height[0]
    )


def test_a_weighted_dome_does_not_care_how_its_mesh_is_turned(coarse_specimen):
    """It is held at its centre; held at the rim, it would be lifted at two of its nodes."""
    specimen = replace(coarse_specimen, mesh=MeshSize(0.006), gravity=1.0).with_milestones([1.06])
    mesh = generate_mesh(specimen)
    turn = Rotation.from_rotvec([0, 0, 0.3]).as_matrix()[:2, :2]
    turned = PlanarMesh(mesh.points @ turn.T, mesh.triangles, mesh.region)
    on_any = specimen.with_layer("kirigami", pattern=None)  # the mesh says where it is cut
    first, second = (
        solve(on_any, "dshell", mesh=each).position.values[0] for each in (mesh, turned)
    )
    assert rms_distance(first, second, np.ones(len(first))) < 0.005 * specimen.characteristic_length


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"profile": "cubic"}, "solver.profile = 'cubic': expected one of 'linear', 'quadratic'"),
        ({"tolerance": 0.0}, r"solver\.tolerance = 0\.0: expected a number greater than 0"),
        ({"tolerance": 1.0}, r"solver\.tolerance = 1\.0: expected a number less than 1"),
        ({"ramp": -1.0}, r"solver\.ramp = -1\.0: expected a number from"),
        ({"max_iterations": 0}, r"solver\.max_iterations = 0: expected a whole number"),
    ],
)
def test_bad_settings_are_named(values, message):
    with pytest.raises(InputError, match=message):
        MorleySettings(**values)


def test_the_path_ends_where_the_law_of_a_layer_locks(coarse_specimen, coarse_mesh):
    """Incompressible, with I1 - 3 = 0.3 at an equal stretch of 1.178."""
    locking = coarse_specimen.with_layer("substrate", material=Gent(39e3, 0.3))
    result = solve(locking.with_milestones([1.03, 1.2]), "dshell", mesh=coarse_mesh)
    assert result.converged.values.tolist() == [1, 0]
    expected = "the flat sheet is out of reach at 1.2: the law of a layer locks"
    assert expected in result.attrs["stop_reason"]
