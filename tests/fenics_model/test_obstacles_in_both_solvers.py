"""Sheets that lie on a table or are held off a ball, by the shell and by the solid."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("dolfinx")
from bilayer import InputError, SphereObstacle, generate_mesh, read_specimen, solve
from bilayer.contact.package import contact_is_installed
from bilayer.errors import ComputationError
from dshell.settings import MorleySettings
from fenics_model.settings import SolidSettings

EXAMPLE = Path(__file__).parents[2] / "examples" / "on_a_table.toml"
COARSE = ["mesh.size='8 mm'", "prestretch.milestones=[1.02]"]
SHELL, SOLID = MorleySettings(contact="barrier"), SolidSettings(contact="barrier")


@pytest.fixture(scope="module", autouse=True)
def needs_ipctk():
    if not contact_is_installed():
        pytest.skip("needs ipctk")


@pytest.fixture(scope="module")
def sheet():
    return read_specimen(EXAMPLE, COARSE)


@pytest.fixture(scope="module")
def mesh(sheet):
    return generate_mesh(sheet)


@pytest.fixture(scope="module")
def shell(sheet, mesh):
    return solve(sheet, "dshell", SHELL, mesh=mesh)


@pytest.fixture(scope="module")
def solid(sheet, mesh, shell):
    return solve(sheet, "fenics", SOLID, mesh=mesh, start=shell)


def weight(sheet, mesh):
    """Of what is stretched there is less on the same area."""
    stretched, other = sheet.layers
    per_area = stretched.density * stretched.thickness / 1.02**2 + other.density * other.thickness
    return sheet.gravity * mesh.areas.sum() * per_area


@pytest.mark.parametrize(("solver", "balance"), [("shell", 1e-7), ("solid", 1e-8)])
def test_the_table_carries_the_weight(request, sheet, mesh, solver, balance):
    result = request.getfixturevalue(solver)
    assert result["converged"].values.all()
    assert result["unstable_modes"].values[0] == 0
    force = result["contact_force"].values[0]
    assert force == pytest.approx(weight(sheet, mesh), rel=balance)
    assert 0 < result["contact_gap"].values[0] < 0.1e-3
    assert result["contact_crosses"].values[0] == 0


def test_the_sheet_stands_on_its_rim(mesh, shell, solid):
    far = np.abs(mesh.points).sum(axis=1)
    corners, middle = far > far.max() * 0.999, mesh.centre_node
    assert corners.sum() == 4
    for result in (shell, solid):
        heights = result["position"].values[0][:, 2]
        assert heights[middle] > heights[corners].max() + 1e-3
        assert np.ptp(heights[corners]) < 0.05e-3
    pressure = solid["contact_pressure"].values[0]
    pressed = mesh.triangles[pressure > 0]
    on_rim = (np.abs(mesh.points) > (1 - 1e-6) * np.abs(mesh.points).max(axis=0)).any(axis=1)
    assert 0 < len(pressed) < len(mesh.triangles)
    assert on_rim[pressed].any(axis=1).all()


def test_a_ball_props_up_one_end(sheet, mesh):
    """Held at its centre, the sheet would sink onto where the ball is."""
    ball = SphereObstacle("ball", (0.018, 0.0, -0.0106), 0.01)
    propped = replace(sheet, obstacles=(ball,)).with_milestones([1.01])
    for solver, settings in (("dshell", SHELL), ("fenics", SOLID)):
        result = solve(propped, solver, settings, mesh=mesh, start="flat")
        assert result["converged"].values.all()
        assert result["contact_force"].values[0] > 0
        away = np.linalg.norm(result["position"].values[0] - ball.centre, axis=1)
        assert away.min() > ball.radius + 0.5e-3


@pytest.mark.parametrize(("solver", "settings"), [("dshell", SHELL), ("fenics", SOLID)])
def test_obstacles_take_contact_and_room(sheet, mesh, solver, settings, monkeypatch):
    without = replace(settings, contact="none")
    with pytest.raises(InputError, match=r"solver.contact = 'none': .*obstacles.table"):
        solve(sheet, solver, without, mesh=mesh)
    inside = replace(sheet, obstacles=(SphereObstacle("ball", (0.0, 0.0, 0.0), 0.01),))
    with pytest.raises(InputError, match=r"obstacles.ball: reaches .* into the flat sheet"):
        solve(inside, solver, settings, mesh=mesh)
    monkeypatch.setitem(sys.modules, "ipctk", None)
    with pytest.raises(ComputationError, match=r"ipctk: pip install 'bilayer-shells\[contact\]'"):
        solve(sheet, solver, settings, mesh=mesh)
