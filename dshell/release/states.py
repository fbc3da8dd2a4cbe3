"""The shell as a finder of stable shapes; see `bilayer.solvers.contract.StateFinder`."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from bilayer.mesh.planar import flat_surface
from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import StretchPair
from dshell.release.effort import ShellEffort
from dshell.release.specimen_path import VERSIONS, ShellEquilibrium
from dshell.release.specimen_shell import SpecimenShell
from dshell.release.static import ShellState, StaticPath
from dshell.solve.deflation import ShapeDeflation
from dshell.solve.newton import EquilibriumSolver, Outcome

Array = NDArray[np.float64]

ITERATIONS = 100
"""Of Newton's method from one start; one that needs more is given up."""
DEFLATED_ITERATIONS = 40
DEFLATED_STEP = 0.1
"""Of a deflated Newton step, largest change of a coordinate over the characteristic length."""
REPULSION = 0.5
"""Distance over the characteristic length within which a known shape repels."""
MOST_MODES = 4
"""Unstable modes of one equilibrium that are followed, those nearest to 0."""


class ShellStateFinder:
    """Finds stable shapes of a specimen's shell at one prestretch.

    Parameters
    ----------
    shell : SpecimenShell
        The specimen.
    solver : EquilibriumSolver
        Of the shell.
    path : StaticPath
        Knows the tolerance of an equilibrium.
    stretch : (float, float)
        The prestretch.
    """

    def __init__(
        self,
        shell: SpecimenShell,
        solver: EquilibriumSolver,
        path: StaticPath[Milestone],
        stretch: StretchPair,
    ) -> None:
        self.mesh = shell.mesh
        self.versions = VERSIONS
        self._shell, self._solver = shell, solver
        self._stretch: Milestone = stretch
        self._body = shell.body(stretch)
        self._limits = path.limits_at(stretch, ITERATIONS)
        areas = flat_surface(shell.mesh).node_areas
        self._areas, self._weights = areas, areas / areas.sum()

    def settle(self, shape: Array) -> list[ShellEquilibrium]:
        """Return the stable shapes downhill of one; see `StateFinder`."""
        guess = self._shell.state_near(shape, self._stretch)
        contact = self._body.contact
        if contact is not None and contact.is_crossed(guess):
            return []
        smooth = self._solver.smooth_guess(self._body, guess, self._limits)
        return list(self._stable_from(self._downhill(smooth), MOST_MODES))

    def settle_elsewhere(self, shape: Array, known: Sequence[Array]) -> list[ShellEquilibrium]:
        """Return the stable shapes beside an equilibrium that is not known; see `StateFinder`."""
        length = self._shell.specimen.characteristic_length
        limits = replace(
            self._limits, iterations=DEFLATED_ITERATIONS, longest_step=DEFLATED_STEP * length
        )
        states = [self._shell.state_near(each, self._stretch) for each in known]
        surfaces = [self._shell.surface(state) for state in states]
        deflation = ShapeDeflation(surfaces, self._weights, REPULSION * length)
        guess = self._shell.state_near(shape, self._stretch)
        found = self._solver.find_nearby_equilibrium(self._body, guess, limits, deflation.factor)
        return list(self._stable_from(found, MOST_MODES))

    def stiffnesses(self, equilibrium: ShellEquilibrium, count: int) -> Array:
        """Return the least eigenvalues of the stiffness per area; see `StateFinder`."""
        here = self._solver.configure(self._body, equilibrium.state)
        stiffness = here.hessian()
        factor = self._solver.factor(stiffness)
        size = stiffness.shape[0]
        inverse = LinearOperator((size, size), matvec=factor.solve, dtype=float)
        begin = np.random.default_rng(0).normal(size=size)
        try:
            values = eigsh(
                stiffness, count, M=self._areas_beyond_rigid(equilibrium.state), sigma=0.0,
                OPinv=inverse, v0=begin, return_eigenvectors=False,
            )  # fmt: skip
        except ArpackError:
            return np.full(count, np.nan)
        return np.sort(values)

    def _areas_beyond_rigid(self, state: Array) -> LinearOperator:
        """Return the map from free dofs to areas times displacements, their rigid part taken out.

        The held coordinates fix the position of the shape, which has no stiffness of its own: a
        vibration is measured at the position that makes it least.
        """
        free = self._solver.assembly.free
        count = 3 * len(self.mesh.points)
        roots = np.sqrt(np.repeat(self._areas, 3))
        rigid: Array = np.empty((0, count))
        if not self._shell.specimen.is_placed:
            rigid = np.linalg.qr(roots[:, None] * _rigid_motions(self._shell.surface(state)))[0].T

        def multiply(free_change: Array) -> Array:
            change = np.zeros(len(state))
            change[free] = free_change.reshape(-1)
            scaled = roots * change[:count]
            change = np.zeros(len(state))
            change[:count] = roots * (scaled - rigid.T @ (rigid @ scaled))
            return change[free]

        return LinearOperator((len(free), len(free)), matvec=multiply, dtype=float)

    def _downhill(self, state: Array) -> Outcome:
        return self._solver.find_minimum([self._body], state, self._limits)

    def _stable_from(self, found: Outcome, modes: int) -> Iterator[ShellEquilibrium]:
        """Yield an equilibrium if it is stable, else what lies to both sides of its modes."""
        if not found.converged:
            return
        unstable = self._solver.unstable_modes(self._body, found.state)
        if unstable == 0:
            yield self._equilibrium(found)
            return
        count = min(unstable, modes)
        if count == 0:
            return
        here = self._solver.configure(self._body, found.state)
        try:
            directions = self._solver.unstable_directions(self._body, found.state, count)
        except ArpackError:  # many modes that are alike
            return
        for away in directions:
            for side in (1.0, -1.0):
                pushed = here.pushed(side * self._shell.escape * away)
                yield from self._stable_from(self._downhill(pushed.state), modes // 2)

    def _equilibrium(self, found: Outcome) -> ShellEquilibrium:
        residual = found.residual / self._limits.tolerance
        state = ShellState(
            self._stretch, found.state, residual, 0, 1.0, ShellEffort(found.iterations, 1)
        )
        return ShellEquilibrium(self._shell, self._solver, state, "a guess")


def _rigid_motions(points: Array) -> Array:
    """Return three shifts and three small turns of points, (3 n, 6)."""
    turns = [np.cross(axis, points - points.mean(axis=0)) for axis in np.eye(3)]
    shifts = [np.tile(axis, (len(points), 1)) for axis in np.eye(3)]
    return np.column_stack([motion.reshape(-1) for motion in (*shifts, *turns)])
