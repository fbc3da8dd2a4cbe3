"""Release without time: the equilibria of a shell at its milestones, each from the one before.

A milestone is tried in one step from the last equilibrium, the first one from flat or from a shape
that is given: the prestretch grows over the first iterations and Newton's method goes on from
there. Where it fails, the prestretch goes there in smaller steps. An equilibrium with unstable
modes is left along one of them (`dshell.release.branches`), so no imperfection is needed; a
bilayer bends by itself.
"""

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import INTERRUPTED, ComputationError
from bilayer.geometry.alignment import aligned, placed
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.results.result import MilestoneState
from bilayer.runtime.progress import Progress
from bilayer.specimen.specimen import Specimen
from dshell.energies.assembly import Assembly, Energy
from dshell.models.interface import bonded_interface
from dshell.models.masses import lumped_masses
from dshell.release.branches import BRANCH_RULES
from dshell.release.rigid_motion import held_coordinates, support
from dshell.release.visit import Visit
from dshell.settings import ReleaseSettings
from dshell.solve.linear_solver import LinearSolver
from dshell.solve.newton import Body, EquilibriumSolver, NewtonLimits, Outcome

Array = NDArray[np.float64]
Stretch = tuple[float, float]

UNSTRETCHED: Stretch = (1.0, 1.0)
ROUND_OFF = 1e-13
"""Residual force, over E t R of the stiffer layer, that no equilibrium can be asked to go below."""
START_ITERATIONS = 50
"""Of Newton's method from a shape that is given; one that needs more leads nowhere."""
ESCAPE = 0.1
"""How far it is left along its unstable mode, over the substrate's thickness."""


class ShellModel(Protocol):
    """What a model is to the load path: its degrees of freedom, and its energies by prestretch."""

    extra_dofs: int
    """Degrees of freedom behind the nodes' coordinates."""

    def energies(self, stretch: Stretch) -> Sequence[Energy]:
        """Return the energies at a prestretch, always on the same stencils."""

    def bond_height(self, stretch: Stretch) -> Array | float:
        """Return the height of the bond above the nodes in the flat state, m, shape (n,) or ()."""

    def energy_terms(self, stretch: Stretch, state: Array) -> Mapping[str, float]:
        """Return the energies that a result lists, J."""


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A state that Newton's method has found.

    Parameters
    ----------
    stretch : (float, float)
        Its prestretch.
    state : array of float
        All degrees of freedom, m.
    residual : float
        Norm of the residual force over that of the flat state.
    unstable_modes : int or None
        How many it has; None where nobody has counted them.
    """

    stretch: Stretch
    state: Array
    residual: float = 0.0
    unstable_modes: int | None = None


class StaticRelease:
    """The load path of a shell.

    Parameters
    ----------
    specimen, mesh
        What is released, on which planar mesh.
    model : ShellModel
        Its energies.
    settings : ReleaseSettings
        Tolerances and limits.
    linear_solver : LinearSolver
        For Newton's steps.
    """

    def __init__(
        self,
        specimen: Specimen,
        mesh: PlanarMesh,
        model: ShellModel,
        settings: ReleaseSettings,
        linear_solver: LinearSolver,
    ) -> None:
        self._specimen, self._mesh, self._model, self._settings = specimen, mesh, model, settings
        size = 3 * len(mesh.points) + model.extra_dofs
        self._held = support(specimen, mesh)
        energies = model.energies(UNSTRETCHED)
        assembly = Assembly(size, energies, held_coordinates(self._held))
        self._solver = EquilibriumSolver(assembly, linear_solver)
        self._longest_step = settings.longest_step * specimen.characteristic_length
        stiffness = max(layer.material.young_modulus * layer.thickness for layer in specimen.layers)
        self._round_off = ROUND_OFF * stiffness * specimen.characteristic_length
        self._branch = BRANCH_RULES[settings.branch](
            self._solver, ESCAPE * specimen.carrier.thickness
        )
        self._iterations = self._load_steps = 0

    def flat(self, stretch: Stretch = UNSTRETCHED) -> Equilibrium:
        """Return the flat bonded state, the model's surface at z = 0."""
        points = np.column_stack([self._mesh.points, np.zeros(len(self._mesh.points))])
        return Equilibrium(stretch, self._state_of(points))

    def started(self, bond: Array, stretch: Stretch) -> Equilibrium | None:
        """Return the equilibrium near a bonded interface at a prestretch, if it is soon found."""
        mesh, depth = self._mesh, -self._model.bond_height(stretch)
        surface = bonded_interface(bond, mesh.triangles, mesh.areas, depth)
        upright = placed(surface, mesh.points, self._held)
        guess = Equilibrium(stretch, self._state_of(upright))
        try:
            few = min(START_ITERATIONS, self._settings.max_iterations)
            found = self._equilibrium(guess, stretch, few)
        except ComputationError:
            return None
        return found if isinstance(found, Equilibrium) else None

    def _state_of(self, nodes: Array) -> Array:
        """Return the state of nodes at (n, 3), m, with every other degree of freedom 0."""
        return np.concatenate([nodes.reshape(-1), np.zeros(self._model.extra_dofs)])

    def _interface(self, here: Equilibrium) -> Array:
        """Return the bonded interface, m, shape (n, 3).

        A shape without weight has no orientation of its own: it is turned to lie on the flat disc
        as well as it can, and not as the held nodes happen to tilt it.
        """
        mesh = self._mesh
        surface = here.state[: 3 * len(mesh.points)].reshape(-1, 3)
        height = self._model.bond_height(here.stretch)
        shape = bonded_interface(surface, mesh.triangles, mesh.areas, height)
        if self._specimen.gravity > 0:
            return shape
        flat = flat_surface(mesh)
        return aligned(shape, flat.points, flat.node_areas)

    def _body(self, stretch: Stretch) -> Body:
        """Return the shell at a prestretch, with its weight."""
        masses = lumped_masses(self._specimen, self._mesh, stretch)
        load = np.zeros((len(masses), 3))
        load[:, 2] = -self._specimen.gravity * masses
        return Body(self._model.energies(stretch), self._state_of(load))

    def approach(self, start: Equilibrium, target: Stretch) -> Iterator[Equilibrium]:
        """Go to a prestretch, in one step if that works.

        Yields
        ------
        Equilibrium
            Each one on the way; the last is at the target.

        Raises
        ------
        ComputationError
            The smallest step fails, too.
        """
        if start.stretch == target and start.unstable_modes is not None:
            yield start
            return
        share, step = 0.0, 1.0
        here = start
        while share < 1:
            end = min(1.0, share + step)
            stretch = between(start.stretch, target, end)
            found = self._equilibrium(here, stretch, self._settings.max_iterations)
            if isinstance(found, Equilibrium):
                share, here = end, found
                yield here
            elif step / 2 < self._settings.smallest_step:
                raise ComputationError(
                    f"Newton's method did not converge: residual {found.residual:.3g} N "
                    f"after {found.iterations} iterations, in a step to {max(stretch):.6g}"
                )
            else:
                step /= 2

    def milestone_state(
        self, here: Equilibrium, converged: bool, wall_time: float
    ) -> MilestoneState:
        """Return what a result keeps of an equilibrium, and of the work since the last one."""
        stretch, state = here.stretch, here.state
        iterations, load_steps = self._iterations, self._load_steps
        self._iterations = self._load_steps = 0
        return MilestoneState(
            self._interface(here),
            converged=converged,
            reached=max(stretch),
            energy=self._model.energy_terms(stretch, state),
            iterations=iterations,
            load_steps=load_steps,
            residual=here.residual,
            unstable_modes=self._unstable_modes(here),
            wall_time=wall_time,
        )

    def _unstable_modes(self, here: Equilibrium) -> int:
        if here.unstable_modes is not None:
            return here.unstable_modes
        return self._solver.unstable_modes(self._body(here.stretch), here.state)

    def _equilibrium(
        self, here: Equilibrium, stretch: Stretch, iterations: int
    ) -> Equilibrium | Outcome:
        """Settle at a prestretch; return the outcome as it is where that fails."""
        body = self._body(stretch)
        scale = self._force_scale(body, stretch)
        tolerance = self._settings.tolerance * scale
        limits = NewtonLimits(tolerance, iterations, self._longest_step)
        bodies = self._ramp(here.stretch, body, stretch)
        found = self._branch.land(bodies, here.state, here.unstable_modes, limits)
        outcome = found.outcome
        self._iterations += outcome.iterations
        self._load_steps += 1
        if not outcome.converged:
            return outcome
        return Equilibrium(stretch, outcome.state, outcome.residual / scale, found.unstable_modes)

    def _ramp(self, start: Stretch, body: Body, end: Stretch) -> list[Body]:
        """Return the shell on its way to a prestretch, one body per iteration, and at its end."""
        way = max(abs(b - a) for a, b in zip(start, end, strict=True))
        count = math.ceil(way / self._settings.ramp)
        shares = np.arange(1, count) / count
        return [*(self._body(between(start, end, float(share))) for share in shares), body]

    def _force_scale(self, body: Body, stretch: Stretch) -> float:
        """Return what the tolerance is relative to, N: the forces on the flat state.

        It is at least so large that the tolerance is not below round-off, as it would be without
        prestretch.
        """
        weightless = Body(body.energies, 0 * body.load)
        flat = self._solver.placed(weightless, self.flat(stretch).state)
        forces = flat.error + float(np.linalg.norm(body.load))
        return max(forces, self._round_off / self._settings.tolerance)


def visit_milestones(
    specimen: Specimen,
    path: StaticRelease,
    start: Array | None,
    progress: Progress | None,
) -> Visit:
    """Visit the milestones of a specimen in their order.

    Parameters
    ----------
    specimen : Specimen
        Whose milestones.
    path : StaticRelease
        How one goes from one to the next; or its like in time.
    start : (n, 3) array of float or None
        Bonded interface that starts the first milestone, m; None: flat.
    progress : callable or None
        See `bilayer.runtime.progress.Progress`.
    """
    milestones = specimen.prestretch.milestones
    begun = time.perf_counter()
    begin = None if start is None else path.started(start, milestones[0])
    lost_start = begin is None and start is not None
    here = begin or path.flat()
    states: list[MilestoneState] = []
    for index, stretch in enumerate(milestones):
        failure = ""
        try:
            for equilibrium in path.approach(here, stretch):
                here = equilibrium
                _report(progress, (index + (here.stretch == stretch)) / len(milestones), here)
        except ComputationError as error:
            failure = f"stopped at prestretch {max(here.stretch):.6g}: {error}"
        except KeyboardInterrupt:
            if not states:
                raise
            return Visit(states, INTERRUPTED, lost_start)
        now = time.perf_counter()
        states.append(path.milestone_state(here, not failure, now - begun))
        begun = now
        if failure:
            return Visit(states, failure, lost_start)
    return Visit(states, "", lost_start)


def _report(progress: Progress | None, share: float, here: Equilibrium) -> None:
    if progress is not None:
        progress(share, f"prestretch {max(here.stretch):g}")


def between(start: Stretch, end: Stretch, share: float) -> Stretch:
    """Return the stretch at a share of the way; the end itself at 1."""
    if share == 1:
        return end
    x, y = (a + share * (b - a) for a, b in zip(start, end, strict=True))
    return x, y
