"""Release in time: the motion of the shell's mass under drag, until it rests in an equilibrium.

From each milestone to the next the prestretch grows linearly over the first half of the time; in
the second half nothing changes and drag takes the motion away. Implicit Euler's time steps find
their own length (`dshell.solve.dynamics.adaptive_euler`). Nodes carry the mass; what else a model
adds to the state, such as Morley's displacements of the edges, has none and follows at once.
"""

from collections.abc import Iterator

import numpy as np

from bilayer.errors import ComputationError
from dshell.models.masses import lumped_masses
from dshell.release.rigid_motion import held_coordinates
from dshell.release.static import Equilibrium, StaticRelease, Stretch, between
from dshell.solve.dynamics import (
    AdaptiveStepping,
    ConvergenceError,
    Motion,
    MovingBody,
    NewtonRule,
    adaptive_euler,
)

RAMP = 0.5
"""Share of the time in which the prestretch grows."""
ITERATIONS = 12
"""Allowed in one time step; a step that needs more is halved."""
AT_REST = 1e-6
"""Force out of balance at the end, over that of the flat state, that still counts as rest."""


class DynamicRelease(StaticRelease):
    """The load path of a shell as a motion; see `StaticRelease` for its parameters."""

    def approach(self, start: Equilibrium, target: Stretch) -> Iterator[Equilibrium]:
        """Move to a prestretch and come to rest there.

        Yields
        ------
        Equilibrium
            The state after each time step, not at rest but for the last, which is at the target.

        Raises
        ------
        ComputationError
            The shortest time step does not converge, or the body is not at rest at the end.
        """
        settings, body = self._settings, self._body(target)
        scale = self._force_scale(body, target)
        rule = NewtonRule(settings.tolerance * scale, ITERATIONS)
        stepping = AdaptiveStepping(settings.time_step, settings.total_time, rule)
        still = Motion(0.0, start.state, np.zeros_like(start.state))
        here = start
        try:
            for motion in adaptive_euler(self._moving(start.stretch, target), still, stepping):
                self._iterations += motion.iterations
                self._load_steps += 1
                stretch = self._stretch_at(start.stretch, target, motion.time)
                moved = self._solver.placed(self._body(stretch), motion.position)
                here = Equilibrium(stretch, motion.position, moved.error / scale)
                if motion.time < stepping.end:
                    yield here
        except ConvergenceError as stop:
            self._iterations += stop.iterations
            raise
        if here.residual > AT_REST:
            raise ComputationError(
                f"the body still moves after solver.total_time = {settings.total_time:g} s: force "
                f"out of balance {here.residual:.1e} of that of the flat state, expected {AT_REST}"
            )
        yield here

    def _moving(self, start: Stretch, target: Stretch) -> MovingBody:
        """Return what moves from one prestretch to another."""
        masses = np.repeat(lumped_masses(self._specimen, self._mesh, target), 3)
        return MovingBody(
            np.concatenate([masses, np.zeros(self._model.extra_dofs)]),
            held_coordinates(self._held),
            energies=lambda now: self._model.energies(self._stretch_at(start, target, now)),
            load=lambda now: self._body(self._stretch_at(start, target, now)).load,
            damping_rate=self._settings.damping_rate,
        )

    def _stretch_at(self, start: Stretch, target: Stretch, now: float) -> Stretch:
        return between(start, target, min(1.0, now / (RAMP * self._settings.total_time)))
