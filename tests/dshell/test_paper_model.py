"""The paper's model as a whole, on a coarse mesh and a short ramp."""

from dataclasses import replace

import numpy as np
import pytest

from bilayer import InputError, PlanarMesh, solve
from bilayer.specimen.two_layers import KIRIGAMI
from dshell import PaperSettings
from dshell.models.masses import lumped_masses
from dshell.models.paper_rest_state import rest_state
from dshell.release.paper import paper_body

SETTINGS = PaperSettings(total_time=0.3, time_step=0.005)


@pytest.fixture(scope="module")
def gentle(coarse_specimen):
    return coarse_specimen.with_milestones([1.01])


@pytest.fixture(scope="module")
def released(gentle, coarse_mesh):
    return solve(gentle, "dshell", SETTINGS, mesh=coarse_mesh)


def test_released_disc_is_a_dome_with_its_apex_up(released, coarse_mesh):
    height = released.position.values[0, :, 2]
    assert released.converged.values.tolist() == [1]
    assert height[coarse_mesh.centre_node] - height[coarse_mesh.rim_nodes].max() > 3e-3


def test_node_nearest_to_the_origin_is_held(released, coarse_mesh):
    centre = released.position.values[0, coarse_mesh.centre_node]
    assert centre == pytest.approx(np.zeros(3), abs=1e-4)  # the normal there may tilt a little


def test_result_counts_and_energies(released):
    assert released.attrs["stop_reason"] == ""
    assert released.load_steps.values.tolist() == [60]
    assert released.iterations.values[0] >= 60
    assert released.residual.values[0] <= SETTINGS.tolerance
    assert released.unstable_modes.values.tolist() == [-1]
    energies = dict(zip(released.term.values, released.energy.values[0], strict=True))
    assert set(energies) == {"stretching", "bending", "kinetic"}
    assert min(energies.values()) > 0


def test_each_layer_has_the_mass_of_its_own_density(gentle, coarse_mesh):
    heavy = gentle.with_layer("substrate", density=700.0).with_layer("kirigami", density=1900.0)
    masses = lumped_masses(heavy, coarse_mesh, (1.2, 1.1))
    on_faces = 700.0 * 1e-3 / 1.32 + 1900.0 * 1e-3 * (coarse_mesh.region == KIRIGAMI)
    of_thirds = np.repeat(on_faces * coarse_mesh.areas / 3, 3)
    assert masses == pytest.approx(np.bincount(coarse_mesh.triangles.ravel(), of_thirds))


def test_drag_takes_the_swinging_away(released, gentle, coarse_mesh):
    """Of the fastest motions implicit Euler takes much by itself, of the slow ones little."""
    settings = replace(SETTINGS, damping_rate=0.0)
    undamped = solve(gentle, "dshell", settings, mesh=coarse_mesh)
    with_drag, without = (
        float(result["energy"].sel(term="kinetic")[0]) for result in (released, undamped)
    )
    assert without > 2 * with_drag


def test_gravity_tapers_linearly_from_the_weight_to_nothing(gentle, coarse_mesh):
    ramp = rest_state(gentle, coarse_mesh, (1.01, 1.01))
    body = paper_body(gentle, coarse_mesh, ramp, (1.01, 1.01), SETTINGS)
    pulls = [body.load(share * SETTINGS.total_time).sum(axis=0) for share in (0, 0.25, 1)]
    weight = SETTINGS.gravity * body.masses[:, 0].sum()
    assert np.array(pulls) == pytest.approx(
        np.array([[0, 0, -weight], [0, 0, -0.75 * weight], [0] * 3])
    )


def relabelled(mesh, rng):
    """The same mesh with nodes, triangles and their first corners in another order."""
    order, faces = rng.permutation(len(mesh.points)), rng.permutation(len(mesh.triangles))
    triangles = np.roll(np.argsort(order)[mesh.triangles[faces]], 1, axis=1)
    return PlanarMesh(mesh.points[order], triangles, mesh.region[faces]), order


def test_numbering_does_not_matter(released, gentle, coarse_mesh):
    mesh, order = relabelled(coarse_mesh, np.random.default_rng(5))
    again = solve(gentle, "dshell", SETTINGS, mesh=mesh)
    assert again.position.values[0] == pytest.approx(released.position.values[0, order], abs=1e-8)


def test_mirrored_mesh_gives_the_mirrored_shape(released, gentle, coarse_mesh):
    flip = np.array([1, -1, 1])
    mirrored = PlanarMesh(
        coarse_mesh.points * flip[:2], coarse_mesh.triangles[:, ::-1], coarse_mesh.region
    )
    again = solve(gentle, "dshell", SETTINGS, mesh=mirrored)
    assert again.position.values[0] == pytest.approx(released.position.values[0] * flip, abs=1e-8)


def test_failure_keeps_the_last_shape_and_the_other_milestones(coarse_specimen, coarse_mesh):
    """A time step too long for the larger prestretch; few iterations make it certain."""
    specimen = coarse_specimen.with_milestones([1.0001, 1.24])
    settings = PaperSettings(total_time=1.0, time_step=0.005, max_iterations=6)
    result = solve(specimen, "dshell", settings, mesh=coarse_mesh)
    assert result.converged.values.tolist() == [1, 0]
    assert np.isfinite(result.position.values[0]).all()
    assert np.isnan(result.position.values[1]).all()
    assert np.isfinite(result.last_position.values[1]).all()
    steps = result.load_steps.values[1]
    assert 0 < steps < settings.steps
    assert result.last_prestretch.values[1] == pytest.approx(1 + 0.24 * steps / settings.steps)
    assert result.residual.values[1] > settings.tolerance
    reason = f"prestretch 1.24 stopped after {steps / settings.steps:.0%} of its ramp: Newton"
    assert result.attrs["stop_reason"].startswith(reason)


def test_thickness_rule_is_the_settings_one(gentle, coarse_mesh, released):
    asked = replace(gentle, prestretch=replace(gentle.prestretch, thickness="constant"))
    same = solve(asked, "dshell", SETTINGS, mesh=coarse_mesh)
    other = solve(gentle, "dshell", replace(SETTINGS, thickness="natural"), mesh=coarse_mesh)
    assert np.array_equal(same.position, released.position)
    assert np.abs(other.position - released.position).max() > 1e-6


def test_progress_runs_from_zero_to_one(coarse_specimen, coarse_mesh):
    seen = []
    settings = PaperSettings(total_time=0.1, time_step=0.02)
    specimen = coarse_specimen.with_milestones([1.0001, 1.0002])
    solve(
        specimen, "dshell", settings, mesh=coarse_mesh,
        progress=lambda share, text: seen.append((share, text)),
    )  # fmt: skip
    shares = [share for share, _ in seen]
    assert shares == pytest.approx(np.arange(1, 11) / 10)
    assert seen[5][1] == "prestretch 1.00004"


def test_mesh_is_made_where_none_is_given(coarse_specimen, coarse_mesh):
    settings = PaperSettings(total_time=0.01, time_step=0.01)
    result = solve(coarse_specimen.with_milestones([1.001]), "dshell", settings)
    assert result.sizes["node"] == len(coarse_mesh.points)


def test_true_weight_is_refused(gentle, coarse_mesh):
    with pytest.raises(InputError, match=r"gravity\.acceleration = 9\.81 m/s2: .*expected 0"):
        solve(replace(gentle, gravity=9.81), "dshell", SETTINGS, mesh=coarse_mesh)


def test_start_is_refused(gentle, coarse_mesh, released):
    with pytest.raises(InputError, match="each milestone from flat"):
        solve(gentle, "dshell", SETTINGS, mesh=coarse_mesh, start=released)


def test_settings_of_another_kind_are_refused(gentle, coarse_mesh):
    with pytest.raises(InputError, match=r"expected one of .*PaperSettings"):
        solve(gentle, "dshell", "paper", mesh=coarse_mesh)
