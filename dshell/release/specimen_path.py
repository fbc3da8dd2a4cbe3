"""The load path of a specimen by the models `morley` and `hinge`, as the contract has it.

See `bilayer.solvers.contract` for the contract, `dshell.release.static` and
`dshell.release.dynamic` for how the path goes.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from typing import Any

import numpy as np
import scipy
import xarray as xr
from numpy.typing import NDArray

from bilayer.contact.package import PACKAGE as CONTACT_PACKAGE
from bilayer.contact.touching import Touching, measure_touching
from bilayer.errors import ComputationError, InputError
from bilayer.measures.milestone import Measures, measure
from bilayer.mechanics.layer_state import LayerState
from bilayer.results.contact_variables import contact_dataset
from bilayer.results.starting import FLAT_START
from bilayer.solvers.contract import Recorded, Saved
from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import UNSTRETCHED, StretchPair, stretch_of
from dshell.release.effort import ShellEffort
from dshell.release.linearised import LinearisedShell
from dshell.release.specimen_shell import SpecimenShell
from dshell.release.static import ShellState, StaticPath
from dshell.solve.newton import EquilibriumSolver

Array = NDArray[np.float64]

START_ITERATIONS = 50
"""Of Newton's method from a shape that is given; one that needs more leads nowhere."""
NOT_COUNTED = -1
VERSIONS = {"scipy": scipy.__version__}


@dataclass(frozen=True, eq=False)
class Beginning:
    """The start of a path.

    Parameters
    ----------
    shape : (n, 3) array of float or None
        The reference surface that leads to the first target, m; None: the flat state does.
    text : str
        Where it comes from, in a line.
    """

    shape: Array | None
    text: str


Begin = Callable[[Milestone], Beginning]
"""Returns how a path begins, given its first target."""


class ShellEquilibrium:
    """A state of a specimen's shell on its path; see `bilayer.solvers.contract.Equilibrium`.

    Parameters
    ----------
    shell : SpecimenShell
        The specimen.
    solver : EquilibriumSolver
        Of the shell.
    found : ShellState
        The state.
    start : str
        How the path began, which is saved with the state.
    """

    def __init__(
        self,
        shell: SpecimenShell,
        solver: EquilibriumSolver,
        found: ShellState[Milestone],
        start: str,
    ) -> None:
        self._shell, self._solver, self._found, self._start = shell, solver, found, start

    @property
    def share(self) -> float:
        """Part of the way to the target."""
        return self._found.share

    @property
    def effort(self) -> ShellEffort:
        """The work since the state before."""
        return self._found.effort

    @property
    def stretch(self) -> StretchPair:
        """Its prestretch."""
        return stretch_of(self._found.load)

    @property
    def milestone(self) -> Milestone:
        """Its prestretch and loads."""
        return self._found.load

    @property
    def responses(self) -> Mapping[str, float]:
        """What each load does its work on, by its name."""
        return self._shell.loading.responses(self.milestone, self.state)

    @property
    def state(self) -> Array:
        """All degrees of freedom, m."""
        return self._found.state

    @cached_property
    def position(self) -> Array:
        """The reference surface, m, shape (n, 3)."""
        return self._shell.position(self.milestone, self.state)

    @property
    def energy(self) -> Mapping[str, float]:
        """Energy terms, J."""
        terms = self._shell.model.energy_terms(self.stretch, self.state)
        contact = self._shell.contact(self.stretch)
        return terms if contact is None else {**terms, "contact": contact.at(self.state).energy}

    @property
    def residual(self) -> float:
        """Norm of the residual force over that of the flat state."""
        return self._found.residual

    @cached_property
    def unstable_modes(self) -> int:
        """Number of unstable modes, counted now if nobody has."""
        if self._found.unstable_modes is not None:
            return self._found.unstable_modes
        return self._solver.unstable_modes(self._shell.body(self.milestone), self.state)

    def measures(self) -> Measures:
        """Return the measures of the shape."""
        return measure(self._shell.specimen, self._shell.mesh, self.stretch, self.position)

    def details(self) -> Touching | None:
        """Return how the sheet touches itself; None if its contact is not modelled."""
        contact = self._shell.contact(self.stretch)
        if contact is None:
            return None
        return measure_touching(contact.skin, contact.barrier, contact.at(self.state).barrier)

    def layer_states(self) -> list[LayerState]:
        """Return the deformation of each layer; none by the model `hinge`."""
        return self._shell.layer_states(self.milestone, self.state)

    def save(self) -> Saved:
        """Return the state, and how the path began."""
        modes = self._found.unstable_modes
        return {
            "stretch": np.array(self.milestone),
            "state": self.state,
            "residual": np.array(self.residual),
            "unstable_modes": np.array(NOT_COUNTED if modes is None else modes),
            "start": np.array(self._start),
            **({} if self._shell.memory is None else self._shell.memory.save()),
        }

    def linearised(self) -> LinearisedShell:
        """Return the equations linearised here, the stiffness factorised."""
        if self._shell.memory is not None:
            raise ComputationError("linearised: not of layers that relax, expected no [time]")
        return LinearisedShell(self._shell, self._solver.assembly, self.milestone, self.state)


class ShellPath:
    """The load path of a specimen's shell; see `bilayer.solvers.contract.SpecimenPath`.

    Parameters
    ----------
    shell : SpecimenShell
        The specimen.
    solver : EquilibriumSolver
        Of the shell.
    path : StaticPath
        How it goes from milestone to milestone.
    begins : sequence of callable
        The first takes the first target and returns the `Beginning`; called when the path is asked
        for it. Further ones do the same for further targets: their shapes lead to them, and not the
        equilibrium before.
    """

    comm = None

    def __init__(
        self,
        shell: SpecimenShell,
        solver: EquilibriumSolver,
        path: StaticPath[Milestone],
        begins: Sequence[Begin],
    ) -> None:
        self.mesh = shell.mesh
        self._shell, self._solver, self._path = shell, solver, path
        self._begins = list(begins)
        self._is_begun = False
        self._visited = 0
        self.start = FLAT_START
        self.versions = VERSIONS
        if shell.contact(UNSTRETCHED) is not None:
            self.versions = VERSIONS | {CONTACT_PACKAGE: version(CONTACT_PACKAGE)}

    def approach(self, target: Milestone) -> Iterator[ShellEquilibrium]:
        """Go to a milestone; see `Path`."""
        if self._begins:
            self._begin_with(self._begins.pop(0)(target), target)
        steps = self._times_to_go()
        for number, time in enumerate(steps):
            for found in self._in_time(target, time):
                share = (number + found.share) / len(steps) if len(steps) > 1 else found.share
                yield self._equilibrium(replace(found, share=share))

    def _times_to_go(self) -> list[float]:
        """Return the ends of the steps of time to the next target, s; that of the release first."""
        memory, schedule = self._shell.memory, self._shell.specimen.schedule
        if memory is None or schedule is None:
            return [0.0]
        self._visited += 1
        series = [layer.relaxation for layer in self._shell.specimen.layers]
        return schedule.steps_to(self._visited - 1, series)

    def _in_time(self, target: Milestone, time: float) -> Iterator[ShellState[Milestone]]:
        """Go to a target at the end of a step of time, which is remembered."""
        memory = self._shell.memory
        if memory is None:
            yield from self._path.approach(target)
            return
        memory.aim_at(time)
        here = self._path.stopped()
        self._path.move_to(replace(here, unstable_modes=None), here.effort)  # it is none any more
        for found in self._path.approach(target):
            if found.share == 1:
                self._shell.arrive(target, found.state)
            yield found

    def _begin_with(self, beginning: Beginning, target: Milestone) -> None:
        """Go to the equilibrium near a shape, or stay where the path is: flat, at first."""
        first, self._is_begun = not self._is_begun, True
        if first:
            self.start = beginning.text
        if beginning.shape is None:
            return
        guess = self._shell.state_near(beginning.shape, target)
        if not self._path.begin_near(guess, target, START_ITERATIONS) and first:
            self.start = f"{FLAT_START}, because what was to start it led nowhere: {self.start}"

    def stopped(self) -> ShellEquilibrium:
        """Return the last state; see `Path`."""
        return self._equilibrium(self._path.stopped())

    def _equilibrium(self, found: ShellState[Milestone]) -> ShellEquilibrium:
        return ShellEquilibrium(self._shell, self._solver, found, self.start)

    def restore(self, saved: Saved) -> None:
        """Be in a state that was saved."""
        milestone = tuple(float(value) for value in saved["stretch"])
        if len(milestone) != len(self._shell.unloaded):
            raise InputError(
                f"resume: stretch has {len(milestone)} values, expected {len(self._shell.unloaded)}"
            )
        modes = int(saved["unstable_modes"])
        state = np.asarray(saved["state"], dtype=np.float64)
        whole = np.zeros_like(self._path.stopped().state)
        without_turns = len(whole) - self._shell.model.fold_count  # files of earlier versions
        if state.shape not in (whole.shape, (without_turns,)):
            raise InputError(f"resume: state has the shape {state.shape}, expected {whole.shape}")
        whole[: len(state)] = state
        self._check_has_energy(milestone, whole)
        self._path.move_to(
            ShellState(
                milestone,
                whole,
                float(saved["residual"]),
                None if modes == NOT_COUNTED else modes,
            )
        )
        self._begins, self._is_begun, self.start = [], True, str(saved["start"])
        memory, schedule = self._shell.memory, self._shell.specimen.schedule
        if memory is not None and schedule is not None:
            blocks: Any = self._shell.model.energies(stretch_of(milestone))
            memory.restore(saved, blocks, self._shell.flat(milestone))
            self._visited = schedule.passed(memory.time)

    def restore_neighbour(
        self, saved: Saved, target: Milestone | None = None, change: Array | None = None
    ) -> None:
        """Be in a state that was saved of a specimen nearby, or in the one that is expected."""
        self.restore(
            {
                **saved,
                "unstable_modes": np.array(NOT_COUNTED),
                "stretch": saved["stretch"] if target is None else np.array(target),
                "state": saved["state"] if change is None else saved["state"] + change,
            }
        )

    def _check_has_energy(self, milestone: Milestone, state: Array) -> None:
        """Raise InputError if a state that a file holds is none of a sheet: all in one point."""
        with np.errstate(all="ignore"):
            terms = self._shell.model.energy_terms(stretch_of(milestone), state)
        if not all(np.isfinite(term) for term in terms.values()):
            raise InputError("resume: state has no finite energy, expected that of an equilibrium")

    def variables(self, milestones: Sequence[Recorded | None]) -> xr.Dataset:
        """Return the contact by milestone; an empty dataset if contact is not modelled."""
        if self._shell.contact(UNSTRETCHED) is None:
            return xr.Dataset()
        touching = [None if tried is None else tried.details for tried in milestones]
        count = len(self._shell.specimen.prestretch.milestones)
        return contact_dataset(touching, len(self.mesh.triangles), count)

    def close(self) -> None:
        """Free nothing: Python does."""
