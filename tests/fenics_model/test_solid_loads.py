"""Loads and supports of the solid: forces against energies, known answers, the shell's."""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI
from verification import clamped_plate

from bilayer import (
    InputError,
    Layer,
    Limit,
    LinearElastic,
    Load,
    MeshSize,
    Part,
    Prestretch,
    Rectangle,
    Specimen,
    Support,
    follow,
    generate_mesh,
    open_result,
    solve,
)
from fenics_model.path.load_schedule import LoadPlace, LoadSchedule
from fenics_model.release.specimen_solid import make_solid
from fenics_model.settings import SolidSettings
from fenics_model.solid.state import State
from fenics_model.solve.newton import Newton

PRESSURE, DEAD, PULL, GOAL, DENSE = 70.0, 3e-3, 0.4, 1e-4, 5e3
ALL = (PRESSURE, DEAD, PULL, GOAL, DENSE)


@pytest.fixture(scope="module")
def strip():
    """A short strip, one end clamped, under a load of each kind."""
    end = Part("rim", (Limit("x", ">=", 4e-3),))
    return Specimen(
        Rectangle(8e-3, 4e-3),
        [Layer("strip", 5e-4, LinearElastic(1e6, 0.3))],
        Prestretch([1.0]),
        mesh=MeshSize(3e-3),
        supports=[
            Support("left", "clamped", Part("rim", (Limit("x", "<=", -4e-3),))),
            Support("all", "hinged", Part("rim"), "z"),
        ],
        loads=[
            Load("blow", "pressure", (PRESSURE,)),
            Load("push", "force", (DEAD,), end, (0.6, 0.0, 0.8)),
            Load("pull", "line_force", (PULL,), end, (1.0, 0.0, 0.0)),
            Load("poke", "displacement", (GOAL,), end, (0.0, -1.0, 0.0)),
            Load("body", "body_force", (DENSE,), direction=(0.0, 1.0, 0.0)),
        ],
    )


@pytest.fixture(scope="module")
def body(strip):
    made = make_solid(strip, generate_mesh(strip), SolidSettings(), MPI.COMM_SELF)
    made.load(LoadPlace((1.0, 1.0), 0.0, 0.0, ALL, (1.0,) * 5, (0.0,) * 5))
    return made


def rough(solid):
    values = np.random.default_rng(3).uniform(-1e-5, 1e-5, len(solid.unknown.x.array))
    return State(values)


def bump(x):
    """A displacement that vanishes at the rim."""
    inside = ((x[0] / 4e-3) ** 2 - 1) * ((x[1] / 2e-3) ** 2 - 1)
    return inside * np.stack([x[1] / 2e-3, 1 + x[0] / 4e-3, 1 - x[2] / 3e-4])


def test_the_residual_is_the_derivative_of_the_energy_less_the_work(body):
    """For changes that vanish at the rim: at a free lower edge a pressure has no energy."""
    solid, base, step = body.solid, rough(body.solid), 1e-6
    change = solid.interpolate(bump).values
    with Newton(solid, []) as newton:
        far, near, close, away = (
            solid.potential_energy(base + steps * step * change) for steps in (2, 1, -1, -2)
        )
        slope = (8 * (near - close) - (far - away)) / (12 * step)
        assert newton.residual(base) @ change == pytest.approx(slope, rel=1e-6)


def shift(x):
    """A displacement that does not vanish at the rim, where springs are."""
    return bump(x) + np.stack([1 + 0 * x[0], x[0] / 4e-3, x[1] / 4e-3])


@pytest.mark.parametrize(("change", "pressure"), [(bump, PRESSURE), (shift, 0.0)])
def test_the_tangent_is_the_derivative_of_the_residual(body, change, pressure):
    """Of a pressure's derivative the tangent has the symmetric part, all of it within the rim."""
    solid, base, step = body.solid, rough(body.solid), 1e-7
    along = solid.interpolate(change).values
    other = solid.interpolate(lambda x: change(x) * (1 + x[1] / 2e-3)).values
    body.load(LoadPlace((1.0, 1.0), 0.0, 0.0, (pressure, *ALL[1:]), (1.0,) * 5, (0.0,) * 5))
    with Newton(solid, solid.absent_pressures()) as newton:
        ahead, behind = (newton.residual(base + sign * step * along) for sign in (1, -1))
        with newton.factorise(base) as factors, newton.layout.vectors(along, None) as (x, y):
            factors.matrix.mult(x, y)
            found = newton.layout.read(y) @ other
    body.load(LoadPlace((1.0, 1.0), 0.0, 0.0, ALL, (1.0,) * 5, (0.0,) * 5))
    assert found == pytest.approx((ahead - behind) @ other / (2 * step), rel=1e-6)


def test_responses_are_what_loads_do_their_work_on(body, strip):
    solid = body.solid
    place = LoadPlace((1.0, 1.0), 0.0, 0.0, ALL, (1.0,) * 5, (0.0,) * 5)
    moved = solid.interpolate(lambda x: np.stack([0 * x[0] + 1e-3, 0 * x[0] - 2e-3, 0 * x[0]]))
    found = body.loading.responses(moved, place)
    assert found["push"] == pytest.approx(0.6e-3)
    assert found["pull"] == pytest.approx(4e-3 * 1e-3)
    assert found["body"] == pytest.approx(8e-3 * 4e-3 * 5e-4 * -2e-3)
    assert body.loading.note(moved, place)[3] == pytest.approx(2e-3)
    risen = solid.interpolate(lambda x: np.stack([0 * x[0], 0 * x[0], 0 * x[0] + 1e-3]))
    assert body.loading.responses(risen, place)["blow"] == pytest.approx(8e-3 * 4e-3 * 1e-3 / 3)
    nothing = body.loading.responses(solid.undeformed, place)
    assert nothing["poke"] == pytest.approx(GOAL * 5e2 * len(body.loading._grips["poke"].dofs))


@pytest.fixture(scope="module")
def plate():
    sheet = clamped_plate.plate_specimen(6e-3)
    pressure = [sheet.loads[0].values[clamped_plate.LOADS.index(6.0)], 0.0]
    return replace(sheet, prestretch=Prestretch([1.0]), loads=(Load("blow", "pressure", pressure),))


@pytest.mark.mpi
def test_clamped_plate_is_that_of_von_karman_and_goes_back(plate):
    mesh = generate_mesh(plate)
    up, back = [point for point in follow(plate, "fenics", mesh=mesh) if point.share == 1]
    risen = clamped_plate.von_karman_deflection(6.0)
    assert np.abs(back.position[:, 2]).max() < 1e-6 * clamped_plate.THICKNESS
    assert up.unstable_modes == 0
    assert back.milestone == (1.0, 1.0, 0.0)
    found = solve(plate, "fenics", mesh=mesh)
    rise = found.position.values[0, mesh.centre_node, 2] / clamped_plate.THICKNESS
    assert rise == pytest.approx(risen, rel=0.02)


def test_two_ranks_give_what_one_gives(plate, bilayer_on_ranks, tmp_path):
    from bilayer.specimen.toml import specimen_to_toml

    (tmp_path / "plate.toml").write_text(specimen_to_toml(plate))
    bilayer_on_ranks(2, "solve", "plate.toml", "--solver", "fenics", "-o", "two.nc", "--quiet")
    shared, alone = open_result(tmp_path / "two.nc"), solve(plate, "fenics")
    assert shared.position.values == pytest.approx(alone.position.values, abs=1e-10)
    assert shared.response_blow.values == pytest.approx(alone.response_blow.values, rel=1e-6)


def test_a_displacement_is_held_let_go_and_held_again():
    load = Load("poke", "displacement", (2e-4, "free", 1e-4), Part(point=(0.0, 0.0)))
    sheet = replace(clamped_plate.plate_specimen(8e-3), prestretch=Prestretch([1.0]), loads=(load,))
    shell, solid = solve(sheet, "dshell"), solve(sheet, "fenics")
    assert solid.converged.values.all()
    for result in (shell, solid):
        assert result.displacement_poke.values == pytest.approx([2e-4, 0, 1e-4], abs=2e-6)
        assert abs(result.response_poke.values[1]) < 1e-9
        assert (result.response_poke.values[[0, 2]] > 0).all()


def test_loads_go_along_the_path():
    path = LoadSchedule(scales=[10.0, 1e-3])
    first = path.add_target((1.0, 1.0, 10.0, 1e-3))
    half = path.place(first / 2)
    assert half.values == pytest.approx([5.0, 5e-4])
    assert half.grips == (1.0, 1.0)
    second = path.add_target((1.0, 1.0, 10.0, np.nan))
    between = path.place((first + second) / 2)
    assert between.grips == (1.0, 0.0)
    assert between.forces == pytest.approx([0.0, 0.5])
    assert np.isnan(path.place(second).milestone[3])
    third = path.add_target((1.0, 1.0, 0.0, 1e-3), reached=(0.0, 3e-3))
    assert path.place((second + third) / 2).values == pytest.approx([5.0, 2e-3])
    assert path.targets[0] == (1.0, 1.0, 10.0, 1e-3)


def test_what_this_model_cannot_hold_is_named():
    plate = clamped_plate.plate_specimen(8e-3)
    sliding = replace(plate, supports=(Support("rim", "guided", Part("rim")),))
    with pytest.raises(InputError, match=r"supports.rim.axes = 'z': the finite-element model"):
        solve(sliding, "fenics")
    oblique = Load("poke", "displacement", (1e-4,), Part(point=(0.0, 0.0)), (1.0, 0.0, 1.0))
    with pytest.raises(InputError, match=r"loads.poke.direction = \[.*along an axis"):
        solve(replace(plate, prestretch=Prestretch([1.0]), loads=(oblique,)), "fenics")
