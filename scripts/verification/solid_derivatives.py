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


def strained_solid(materials: Sequence[Law]):
    """Two layers in a smooth, uneven state of finite strain, the lower one prestretched."""
    solid = solid_of(stacked(rectangle(3e-3, 2e-3, 3, 2), [1e-3, 1e-3]), materials)
    solid.layers[0].natural.value = (1.1, 1.05, 1.0)
    solid.state.sub(0).interpolate(_uneven)
    for layer in range(2):
        solid.state.sub(1 + layer).interpolate(lambda x: 1e-4 * np.cos(500 * x[0] + x[2] * 300))
    return solid


def _uneven(x):
    return 1e-4 * np.array(
        [np.sin(600 * x[1]) + 500 * x[0], np.cos(700 * x[0] + 400 * x[2]), np.sin(800 * x[2])]
    )


def _random_direction(solid):
    """A direction that does not depend on the partition, from the values of smooth functions."""
    direction = solid.state.copy()
    frequency, phase = np.random.default_rng(3).uniform(200, 900, (2, 3, 1))
    direction.sub(0).interpolate(lambda x: 1e-3 * np.sin(frequency * x + phase))
    for layer in range(2):
        direction.sub(1 + layer).interpolate(lambda x: 1e-3 * np.sin((frequency * x).sum(axis=0)))
    return direction.x.array.copy()


def derivative_errors(solid) -> tuple[float, float]:
    """Relative errors of residual and tangent against central differences of fourth order.

    Every dof is free here, also the pressures outside their layer.
    """
    newton = newton_of(solid, [])
    newton._held = []
    values, comm = solid.state.x.array, solid.mesh.mesh.comm
    here, along = values.copy(), _random_direction(solid)

    def energy(step):
        values[:] = here + step * along
        return sum(solid.layer_energy(layer) for layer in range(2))

    def residual(step):
        values[:] = here + step * along
        return newton.residual().array.copy()

    def slope(function, h=STEP):
        return (8 * (function(h) - function(-h)) - (function(2 * h) - function(-2 * h))) / (12 * h)

    change = newton.vector()
    owned = slice(0, change.local_size)
    power = comm.allreduce(residual(0.0) @ along[owned])
    first = abs(slope(energy) / power - 1)
    expected = slope(residual)
    values[:] = here
    newton.factorise()
    change.array[:], image = along[owned], change.duplicate()
    newton.matrix.mult(change, image)
    second = comm.allreduce(np.sum((expected - image.array) ** 2)) ** 0.5 / image.norm()
    newton.destroy()
    return float(first), float(second)


def rigid_motion_error(solid) -> float:
    """Largest relative change of energies and of the residual's norm by a rigid motion."""
    newton = newton_of(solid, [])

    def measures():
        return np.array([solid.layer_energy(0), solid.layer_energy(1), newton.residual_norm()])

    before = measures()
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    shift = np.array([[0.3], [-0.2], [0.1]]) * 1e-3
    solid.state.sub(0).interpolate(lambda x: turn @ (x + _uneven(x)) + shift - x)
    error = float(np.abs(measures() / before - 1).max())
    newton.destroy()
    return error


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
