"""The shell as a finder of stable shapes; see `bilayer.solvers.contract.StateFinder`."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from bilayer.errors import ComputationError
from bilayer.geometry.alignment import align
from bilayer.geometry.shape_between import ShapesBetween
from bilayer.mesh.planar import flat_surface
from bilayer.solvers.contract import Pass
from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import StretchPair
from dshell.release.effort import ShellEffort
from dshell.release.specimen_path import VERSIONS, ShellEquilibrium
from dshell.release.specimen_shell import SpecimenShell
from dshell.release.static import ShellState, StaticPath
from dshell.solve.deflation import ShapeDeflation
from dshell.solve.newton import EquilibriumSolver, Outcome
from dshell.solve.saddle import find_saddle
from dshell.solve.string import StringOfStates, StringSearch, between_neighbours

Array = NDArray[np.float64]

ITERATIONS = 100
"""Of Newton's method from one start; one that needs more is given up."""
DEFLATED_ITERATIONS = 40
DEFLATED_STEP = 0.1
"""Of a deflated Newton step, largest change of a coordinate over the characteristic length."""
REPULSION = 0.5
"""Distance over the characteristic length within which a known shape repels."""
STRING_STEP = 0.1
"""Of the states of a string, largest change of a coordinate over the characteristic length."""
CLOSER = 2
"""Times that a string is made shorter, about its highest state, until a pass is found."""
SADDLE_ITERATIONS = 40
SADDLE_STEP = 0.02
"""Of Newton's method at a pass, largest change of a coordinate over the characteristic length."""
ASIDE = 0.01
"""Height of the waves that keep a string from being symmetric, over the same length."""
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
        self._force_scale = path.force_scale_at(stretch)
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

    def find_pass(
        self,
        first: Array,
        second: Array,
        images: int,
        rounds: int,
        tell: Callable[[int], None] | None = None,
    ) -> Pass:
        """Return the way over the lowest pass between two shapes; see `StateFinder`."""
        length = self._shell.specimen.characteristic_length
        start, end = self._settled_state(first), self._settled_state(second)
        weights = np.zeros(len(start))
        weights[: 3 * len(self.mesh.points)] = np.repeat(self._weights, 3)
        search = StringSearch(
            self._solver, self._body, weights, STRING_STEP * length, self._lay_onto
        )
        string = search.relax(self._chain(start, end, images), rounds, tell)
        near, saddle = string, self._saddle_near(string)
        for _ in range(CLOSER):
            if saddle is not None and saddle.unstable_modes == 1:
                break
            near = search.relax(between_neighbours(near), rounds)
            saddle = self._saddle_near(near) or saddle
        sides = () if saddle is None else tuple(self._sides_of(saddle))
        positions = [self._shell.position(self._stretch, state) for state in string.states]
        return Pass(np.stack(positions), string.energies, string.lengths, saddle, sides)

    def _saddle_near(self, string: StringOfStates) -> ShellEquilibrium | None:
        """Return the unstable equilibrium at the top of a string, None if Newton finds none."""
        length = self._shell.specimen.characteristic_length
        limits = replace(
            self._limits, iterations=SADDLE_ITERATIONS, longest_step=SADDLE_STEP * length
        )
        highest = self._held_again(string.states[string.top])
        found = find_saddle(self._solver, self._body, highest, limits)
        if not found.converged:
            return None
        modes = self._solver.unstable_modes(self._body, found.state)
        return self._equilibrium(found, modes) if modes else None

    def _sides_of(self, saddle: ShellEquilibrium) -> Iterator[ShellEquilibrium]:
        """Yield what lies downhill of a saddle, to both sides of its first unstable mode."""
        here = self._solver.configure(self._body, saddle.state)
        (away,) = self._solver.unstable_directions(self._body, saddle.state, 1)
        for side in (1.0, -1.0):
            pushed = here.pushed(side * self._shell.escape * away)
            yield from self._stable_from(self._downhill(pushed.state), MOST_MODES)

    def _settled_state(self, shape: Array) -> Array:
        found = self._downhill(self._shell.state_near(shape, self._stretch))
        if not found.converged:
            raise ComputationError("an end of the way is no equilibrium of the shell")
        return found.state

    def _chain(self, first: Array, second: Array, images: int) -> Array:
        """Return states between two, a little beside the straight way so that none is symmetric."""
        shares = np.linspace(0, 1, images + 2)[:, None]
        second = self._lay_onto(second, first)
        states = first + shares * (second - first)
        between = ShapesBetween(
            self._shell.surface(first), self._shell.surface(second), self.mesh.triangles
        )
        count = 3 * len(self.mesh.points)
        for place in range(1, images + 1):
            states[place, :count] = between.at(float(shares[place, 0])).reshape(-1)
        points = self.mesh.points / np.abs(self.mesh.points).max()
        rng = np.random.default_rng(0)
        waves = sum(
            rng.normal() * np.cos(points @ rng.normal(size=2) * 3 + rng.uniform(0, 6))
            for _ in range(6)
        )
        aside = ASIDE * self._shell.specimen.characteristic_length * np.asarray(waves)
        states[:, 2:count:3] += np.sin(np.pi * shares) * aside
        return np.asarray(states)

    def _lay_onto(self, state: Array, other: Array) -> Array:
        """Return a state after the rigid motion that brings it nearest to another."""
        if self._shell.specimen.is_placed:
            return state
        points, onto = self._shell.surface(state), self._shell.surface(other)
        laid = state.copy()
        laid[: points.size] = align(points, onto, self._weights).reshape(-1)
        return laid

    def _held_again(self, state: Array) -> Array:
        """Return a state that was moved rigidly where the held nodes are."""
        held = self._shell.move_to_held(self._shell.surface(state))
        return np.concatenate([held.reshape(-1), state[held.size :]])

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

    def _equilibrium(self, found: Outcome, modes: int = 0) -> ShellEquilibrium:
        residual = found.residual / self._force_scale
        state = ShellState(
            self._stretch, found.state, residual, modes, 1.0, ShellEffort(found.iterations, 1)
        )
        return ShellEquilibrium(self._shell, self._solver, state, "a guess")


def _rigid_motions(points: Array) -> Array:
    """Return three shifts and three small turns of points, (3 n, 6)."""
    turns = [np.cross(axis, points - points.mean(axis=0)) for axis in np.eye(3)]
    shifts = [np.tile(axis, (len(points), 1)) for axis in np.eye(3)]
    return np.column_stack([motion.reshape(-1) for motion in (*shifts, *turns)])
