"""Slender clamped shells that bend far: strips and the slit ring. SI units, or consistent ones."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from bilayer import LinearElastic
from dshell.energies.assembly import coordinates_of
from dshell.energies.through_thickness import ShellLayer
from dshell.materials.plane_stress import plane_stress_law
from verification.end_moment import EndMoment
from verification.meshes import rectangle, slit_ring
from verification.shell_problem import (
    Problem,
    clamp_layer,
    line_load,
    nodes_of,
    plate,
    pressure,
    single_layer,
    states_on,
)

Array = NDArray[np.float64]


class Strip:
    """A strip along x without Poisson's effect, clamped at x = 0."""

    def __init__(self, length, width, thickness, young, cells=40) -> None:
        self.length, self.width, self.thickness, self.young = length, width, thickness, young
        step = length / cells
        self.mesh = rectangle(
            np.arange(-1, cells + 1) * step, np.linspace(-width / 2, width / 2, 3)
        )
        self.tip = np.flatnonzero(self.mesh.points[:, 0] > length - step / 2)
        self._fixed = np.flatnonzero(self.mesh.points[:, 0] < step / 2)
        self._clamp = clamp_layer(self.mesh, self._fixed, young, thickness)

    def problem(self, layers: Sequence[ShellLayer]) -> Problem:
        """The strip of some layers, without a load."""
        faces, flat = plate(self.mesh, [*layers, self._clamp])
        return Problem(faces, flat, coordinates_of(self._fixed).reshape(-1), np.zeros(len(flat)))

    def middle(self, state: Array) -> Array:
        """The mid-line's points from clamp to tip, (cells + 1, 3)."""
        on_line = np.abs(self.mesh.points[:, 1]) < self.width / 8
        return nodes_of(state, self.mesh)[on_line][1:]


def heavy_strip(weight: float, cells: int = 40) -> float:
    """Drop of the tip over the length of a strip whose q L^3 / E I is the weight."""
    length, thickness, young = 0.1, 1e-3, 1e6
    strip = Strip(length, 0.01, thickness, young, cells)
    problem = strip.problem([single_layer(young, 0.0, thickness)])
    load_per_area = weight * young * thickness**3 / 12 / length**3
    problem.load = pressure(strip.mesh, len(problem.flat_state), -load_per_area)
    line = strip.middle(problem.solved(1e-7, length / 4))
    return float(line[0, 2] - line[-1, 2]) / length


def rolled_strip(turn: float) -> Array:
    """The tip (x, y, -z) over the length of a strip that its natural curvature bends by an angle.

    That is the curvature that an end moment of E I turn / L would give it.
    """
    strip = _moment_strip()
    return _tip(strip, _rolled_up(strip, turn))


def strip_with_end_moment(turn: float) -> Array:
    """The tip (x, y, -z) over the length of a strip that an end moment of E I turn / L bends.

    Newton's method starts from the strip rolled up by its natural curvature: from flat a full
    circle is too far.
    """
    strip = _moment_strip()
    problem = strip.problem([single_layer(strip.young, 0.0, strip.thickness)])
    lines = np.column_stack([strip.tip - len(strip.tip), strip.tip])
    shares = np.ones(len(lines))
    shares[[0, -1]] = 0.5  # edges carry half of what lies inside
    moment = strip.young * strip.width * strip.thickness**3 / 12 * turn / strip.length
    problem.more = [EndMoment(lines, moment * shares / shares.sum(), turn)]
    return _tip(strip, problem.solved(1e-7, strip.length / 4, _rolled_up(strip, turn)))


def _moment_strip() -> Strip:
    return Strip(length=0.1, width=0.01, thickness=1e-3, young=1e6)


def _rolled_up(strip: Strip, turn: float, steps: int = 6) -> Array:
    """State of a strip of two like layers, the lower stretched by m: curvature 3/2 m / t."""
    law = plane_stress_law(LinearElastic(strip.young, 0.0))
    half = strip.thickness / 2
    upper = ShellLayer("upper", law, 0.0, half, np.eye(2))
    state = None
    for mismatch in turn / strip.length * strip.thickness / 1.5 * np.arange(1, steps + 1) / steps:
        lower = ShellLayer("lower", law, -half, 0.0, np.diag([1 + mismatch, 1.0]))
        state = strip.problem([lower, upper]).solved(1e-7, strip.length / 4, state)
    return state


def _tip(strip: Strip, state: Array) -> Array:
    line = strip.middle(state)
    return line[-1] * [1, 1, -1] / np.linalg.norm(np.diff(line, axis=0), axis=1).sum()


def sheared_strip(shares: Sequence[float], cells: int = 40) -> Iterator[Array]:
    """Displacement of the tip at shares of an end shear of 4 (Sze, Liu, Lo 2004, section 3.1)."""
    length, width, thickness, young, force = 10.0, 1.0, 0.1, 1.2e6, 4.0
    strip = Strip(length, width, thickness, young, cells)
    problem = strip.problem([single_layer(young, 0.0, thickness)])
    problem.load = line_load(strip.mesh, len(problem.flat_state), strip.tip, force / width)
    path = problem.path(1e-7, length / 4)
    for state in states_on(path, [(share,) for share in shares]):
        yield strip.middle(state)[-1] - [length, 0.0, 0.0]


def lifted_rings(meshes: Sequence[int]) -> Iterator[tuple[float, float]]:
    """Rise of the inner and the outer end of the free lip (Sze, Liu, Lo 2004, section 3.3).

    Each mesh has so many cells across the ring and ten times as many around it. The load comes at
    once: the ring is so thin that Newton's method needs about 160 iterations, in smaller steps
    more. A finer mesh starts from the shape of the one before; from flat it may lose its way.
    """
    inner, outer, thickness, young, load_per_length = 6.0, 10.0, 0.03, 21e6, 0.8
    before: RegularGridInterpolator | None = None  # positions over angle and radius
    for radial in meshes:
        around = 10 * radial
        angles = 2 * np.pi / around * np.arange(-1, around + 1)  # the first row is the clamp
        radii = np.linspace(inner, outer, radial + 1)
        mesh = slit_ring(inner, outer, radial, angles)
        row = np.arange(radial + 1)
        fixed, lip = np.concatenate([row, row + radial + 1]), row + (around + 1) * (radial + 1)
        layers = [single_layer(young, 0.0, thickness), clamp_layer(mesh, fixed, young, thickness)]
        faces, flat = plate(mesh, layers)
        load = line_load(mesh, len(flat), lip, load_per_length)
        start = flat.copy()
        if before is not None:
            nodes = before(tuple(np.meshgrid(angles, radii, indexing="ij"))).reshape(-1, 3)
            nodes[fixed] = nodes_of(flat, mesh)[fixed]
            start[: nodes.size] = nodes.reshape(-1)
        problem = Problem(faces, flat, coordinates_of(fixed).reshape(-1), load)
        found = nodes_of(problem.solved(1e-6, inner / 6, start, iterations=300), mesh)
        before = RegularGridInterpolator(
            (angles, radii), found.reshape(len(angles), len(radii), 3), "cubic"
        )
        rise = found[lip, 2]
        yield float(rise[0]), float(rise[-1])
