"""Equilibria that a caller holds: one by one, saved, linearised, in any order of the milestones."""

import numpy as np
import pytest

import bilayer
from bilayer import ComputationError, HingeSettings, InputError, MorleySettings, PaperSettings
from bilayer.solvers.parameters import changed, parameter_value
from bilayer.specimen.toml import specimen_to_toml
from dshell.solver import SOLVER

KINDS = pytest.mark.parametrize("kind", [MorleySettings, HingeSettings])
TIGHT = 1e-13


def milestones_of(specimen, mesh, settings):
    """The last equilibrium on the way to each milestone."""
    path = bilayer.follow(specimen, "dshell", settings, mesh=mesh)
    return [equilibrium for equilibrium in path if equilibrium.share == 1]


@KINDS
def test_following_gives_what_solving_gives(coarse_specimen, coarse_mesh, kind):
    specimen = coarse_specimen.with_milestones([1.01, 1.02])
    result = bilayer.solve(specimen, "dshell", kind(), mesh=coarse_mesh)
    for row, found in enumerate(milestones_of(specimen, coarse_mesh, kind())):
        assert found.stretch == specimen.prestretch.milestones[row]
        assert np.array_equal(found.position, result["position"].values[row])
        assert found.measures().shape.height == result["height"].values[row]
        assert found.energy == {
            str(term.item()): result["energy"].sel(term=term).values[row] for term in result["term"]
        }
        assert found.unstable_modes == 0


def test_a_specimen_file_is_followed(coarse_specimen, coarse_mesh, tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(specimen_to_toml(coarse_specimen.with_milestones([1.01])))
    (found,) = bilayer.follow(path, "dshell", HingeSettings())
    assert found.share == 1
    result = bilayer.solve(str(path), "dshell", HingeSettings())
    assert result["converged"].values.tolist() == [1]
    with pytest.raises(InputError, match=r"^specimen = 3: expected a Specimen or the path of its"):
        bilayer.solve(3, "dshell")


def test_a_path_that_ends_raises_when_it_is_followed(coarse_specimen, coarse_mesh):
    specimen = coarse_specimen.with_milestones([1.01, 1.2])
    settings = HingeSettings(max_iterations=3, smallest_step=0.4)
    found = bilayer.follow(specimen, "dshell", settings, mesh=coarse_mesh)
    assert next(found).stretch == (1.01, 1.01)
    with pytest.raises(ComputationError, match="did not converge"):
        list(found)


@KINDS
def test_down_again_is_the_shape_of_the_way_up(coarse_specimen, coarse_mesh, kind):
    """Below the loss of symmetry there is one stable shape, whatever came before."""
    specimen = coarse_specimen.with_milestones([1.005, 1.01, 1.005, (1.01, 1.0), (1.01, 1.01)])
    settings = kind(tolerance=1e-10)
    result = bilayer.solve(specimen, "dshell", settings, mesh=coarse_mesh)
    assert result["converged"].values.all()
    assert result["prestretch"].values.tolist() == [1.005, 1.01, 1.005, 1.01, 1.01]
    up, high, down, other, high_again = result["position"].values
    assert down == pytest.approx(up, abs=1e-8)
    assert high_again == pytest.approx(high, abs=1e-8)
    assert np.abs(other - high).max() > 1e-4


def test_a_milestone_that_comes_at_once_again_costs_nothing(coarse_specimen, coarse_mesh):
    specimen = coarse_specimen.with_milestones([1.01, 1.01])
    result = bilayer.solve(specimen, "dshell", HingeSettings(), mesh=coarse_mesh)
    assert result["iterations"].values[1] == result["load_steps"].values[1] == 0
    assert np.array_equal(*result["position"].values)


@pytest.mark.parametrize(
    "settings",
    [MorleySettings(), HingeSettings(method="dynamic"), PaperSettings(total_time=0.01)],
)
def test_a_path_goes_on_from_what_was_saved(coarse_specimen, coarse_mesh, settings):
    def opened():
        return SOLVER.open_path(
            coarse_specimen, settings, mesh=coarse_mesh, start=None, comm=None, progress=None
        )

    first, other = opened(), opened()
    *_, here = first.approach((1.005, 1.005))
    *_, expected = first.approach((1.008, 1.01))
    other.restore(here.save())
    *_, found = other.approach((1.008, 1.01))
    assert np.array_equal(found.position, expected.position)
    assert (found.effort.iterations, other.start) == (expected.effort.iterations, first.start)


PARAMETERS = (
    "prestretch", "prestretch.x", "prestretch.y", "gravity", "substrate.thickness",
    "kirigami.thickness", "substrate.density", "substrate.material.C10", "kirigami.material.C01",
)  # fmt: skip


def equilibrium_with(specimen, mesh, kind, parameter, change):
    """The equilibrium near 1.02 with a parameter changed, along the same path."""
    other, stretch = changed(specimen, (1.02, 1.02), parameter, change)
    settings = kind(tolerance=TIGHT)
    (found,) = milestones_of(other.with_milestones([stretch]), mesh, settings)
    return found


@KINDS
@pytest.mark.parametrize("parameter", PARAMETERS)
def test_the_tangent_predicts_how_the_equilibrium_changes(
    coarse_specimen, coarse_mesh, kind, parameter
):
    """The error of the prediction falls with the square of the change (Taylor)."""
    specimen = bilayer.parse_specimen(
        specimen_to_toml(coarse_specimen), ["gravity.acceleration=0.3"]
    )
    here = equilibrium_with(specimen, coarse_mesh, kind, parameter, 0.0)
    tangent = here.linearised()
    rate = -tangent.solve(tangent.residual_by(parameter))
    moving = tangent.position_change(rate) + tangent.position_by(parameter)
    size = parameter_value(specimen, (1.02, 1.02), parameter)
    first = 4e-4 if parameter.startswith("prestretch") else 0.1
    errors, moves = [], []
    for share in (first, first / 2):
        change = share * size
        there = equilibrium_with(specimen, coarse_mesh, kind, parameter, change)
        moves.append(np.linalg.norm(there.state - here.state))
        errors.append(
            [
                np.linalg.norm(there.state - here.state - change * rate),
                np.linalg.norm(there.position - here.position - change * moving),
            ]
        )
    assert moves[0] > 0
    rates = np.log2(np.divide(*errors))
    assert ((rates > 1.8) | (np.array(errors[1]) < 1e-7 * moves[1])).all(), (rates, errors, moves)


@pytest.mark.parametrize("gravity", [0.0, 0.3])
@KINDS
def test_the_adjoint_gives_the_derivative_of_a_function_of_the_shape(
    coarse_specimen, coarse_mesh, kind, gravity
):
    specimen = bilayer.parse_specimen(
        specimen_to_toml(coarse_specimen), [f"gravity.acceleration={gravity}"]
    )
    weights = np.random.default_rng(3).normal(size=(len(coarse_mesh.points), 3))
    (here,) = milestones_of(specimen.with_milestones([1.02]), coarse_mesh, kind(tolerance=TIGHT))
    tangent = here.linearised()
    adjoint = tangent.solve(tangent.state_gradient(weights))
    for parameter in ("prestretch.x", "substrate.thickness", "kirigami.material.C10"):
        forward = -tangent.solve(tangent.residual_by(parameter))
        explicit = np.sum(weights * tangent.position_by(parameter))
        by_adjoint = explicit - adjoint @ tangent.residual_by(parameter)
        by_forward = explicit + np.sum(weights * tangent.position_change(forward))
        assert by_adjoint == pytest.approx(by_forward, rel=1e-6)


def test_a_parameter_that_there_is_not_is_told(coarse_specimen, coarse_mesh):
    (here,) = milestones_of(coarse_specimen.with_milestones([1.01]), coarse_mesh, HingeSettings())
    tangent = here.linearised()
    for name in ("paint", "substrate.colour", "substrate.material.C99", "prestretch.z"):
        with pytest.raises(InputError, match=f"^parameter = '{name}': expected prestretch"):
            tangent.residual_by(name)


def test_what_is_held_does_not_move(coarse_specimen, coarse_mesh):
    (here,) = milestones_of(coarse_specimen.with_milestones([1.01]), coarse_mesh, HingeSettings())
    tangent = here.linearised()
    moved = tangent.solve(np.random.default_rng(0).normal(size=here.state.size))
    coordinates = moved[: 3 * len(coarse_mesh.points)]
    assert np.count_nonzero(coordinates == 0) == 6
