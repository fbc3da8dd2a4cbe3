"""Energies of the finite-element model: differences, rigid motion, two ranks. SI units."""

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from mpi4py import MPI

from bilayer import LinearElastic, MeshSize, MooneyRivlin, NeoHookean, open_result, paper_specimen
from bilayer.errors import ComputationError
from bilayer.specimen.materials import Law
from bilayer.specimen.toml import specimen_to_toml
from fenics_model.solid.solid import Solid
from fenics_model.solid.state import State
from fenics_model.solve.newton import Newton
from verification.laws import LAW_CASES
from verification.solid_problem import newton_of, rectangle, solid_of, stacked

PAIRS = {
    "mooney-rivlin": (MooneyRivlin(4839.1, 14536.0, 1e-6), MooneyRivlin(30749.0, 30749.0, 3e-7)),
    "incompressible": (MooneyRivlin(4839.1, 14536.0), MooneyRivlin(30749.0, 30749.0)),
    "neo-hookean": (NeoHookean(19375.0, d1=1e-6), NeoHookean(61498.0, d1=1e-6)),
    "linear": (LinearElastic(116250.0, 0.5), LinearElastic(368988.0, 0.4)),
    "yeoh, gent": tuple(LAW_CASES[name].compressible(1e-6) for name in ("yeoh", "gent")),
    "arruda-boyce, ogden": tuple(LAW_CASES[name].law for name in ("arruda-boyce", "ogden")),
}
"""Laws of the lower and the upper layer."""

STEP = 2e-3
"""Of the differences, along directions of 1 mm."""


def strained_solid(materials: Sequence[Law]) -> tuple[Solid, State]:
    """Two layers, the lower one prestretched, and a smooth, uneven state of finite strain."""
    solid = solid_of(stacked(rectangle(3e-3, 2e-3, 3, 2), [1e-3, 1e-3]), materials)
    solid.layers[0].natural.value = (1.1, 0.02, 1.05, 1.0)
    return solid, solid.interpolate(_uneven, _uneven_pressure, _uneven_pressure)


def _uneven_pressure(x):
    return 1e-4 * np.cos(500 * x[0] + x[2] * 300)


def _uneven(x):
    return 1e-4 * np.array(
        [np.sin(600 * x[1]) + 500 * x[0], np.cos(700 * x[0] + 400 * x[2]), np.sin(800 * x[2])]
    )


def _random_direction(solid):
    """A direction that does not depend on the partition, from the values of smooth functions."""
    frequency, phase = np.random.default_rng(3).uniform(200, 900, (2, 3, 1))

    def pressure(x):
        return 1e-3 * np.sin((frequency * x).sum(axis=0))

    return solid.interpolate(
        lambda x: 1e-3 * np.sin(frequency * x + phase), pressure, pressure
    ).values


def derivative_errors(solid: Solid, state: State) -> tuple[float, float]:
    """Relative errors of residual and tangent against central differences of fourth order.

    Every dof is free here, also the pressures outside their layer.
    """
    along = _random_direction(solid)

    def energy(step):
        return sum(solid.layer_energy(layer, state + step * along) for layer in range(2))

    def slope(function, h=STEP):
        return (8 * (function(h) - function(-h)) - (function(2 * h) - function(-2 * h))) / (12 * h)

    with Newton(solid, []) as newton:
        layout = newton.layout
        power = layout.dot(newton.residual(state), along)
        expected = slope(lambda step: newton.residual(state + step * along))
        with newton.factorise(state) as factors, layout.vectors(along, None) as (change, image):
            factors.matrix.mult(change, image)
            found = layout.read(image)
        second = layout.norm(expected - found) / layout.norm(found)
    return float(abs(slope(energy) / power - 1)), second


def rigid_motion_error(solid: Solid, state: State) -> float:
    """Largest relative change of energies and of the residual's norm by a rigid motion."""
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    shift = np.array([[0.3], [-0.2], [0.1]]) * 1e-3
    moved = solid.interpolate(
        lambda x: turn @ (x + _uneven(x)) + shift - x, _uneven_pressure, _uneven_pressure
    )
    with newton_of(solid, []) as newton:
        before, after = (
            np.array(
                [*(solid.layer_energy(layer, at) for layer in range(2)), newton.residual_norm(at)]
            )
            for at in (state, moved)
        )
    return float(np.abs(after / before - 1).max())


def ranks_difference(ranks: int = 2) -> float:
    """Largest distance between the shapes of the coarse paper's specimen from ranks and from one.

    In metres; by the command line, each in a process of its own.
    """
    if MPI.COMM_WORLD.size > 1:
        raise ComputationError("the ranks are started from a single one")
    specimen = replace(paper_specimen(), mesh=MeshSize(0.012)).with_milestones([1.03])
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "specimen.toml"
        source.write_text(specimen_to_toml(specimen), encoding="utf-8")
        shapes = []
        for count in (1, ranks):
            output = Path(folder) / f"{count}.nc"
            command = ["mpirun", "-n", str(count), sys.executable, "-m", "bilayer", "solve",
                       "--quiet", str(source), "--solver", "fenics", "-o", str(output)]  # fmt: skip
            run = subprocess.run(command, capture_output=True, text=True, check=False)
            if run.returncode:
                raise ComputationError(f"{count} ranks: {run.stderr.strip().splitlines()[-1:]}")
            shapes.append(open_result(output)["position"].values)
    return float(np.abs(shapes[1] - shapes[0]).max())
