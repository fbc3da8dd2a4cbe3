"""The record of a run: each milestone is kept from the moment at which it is reached.

`Recorder` is an observer of the driver. At a milestone it collects the data of a result, measures
the shape, and writes the file so far, before the path goes on. Ctrl-C and SIGTERM wait until that
is done.
"""

from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import INTERRUPTED
from bilayer.measures.milestone import Measures, measure
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.assembly import Provenance, build_result
from bilayer.results.files import ResumePoint, write_result
from bilayer.results.schema import NOT_MEASURED, MilestoneState
from bilayer.results.table import milestone_text, place_words
from bilayer.runtime.ranks import on_first_rank
from bilayer.runtime.termination import signals_put_off
from bilayer.runtime.time_limit import TimeIsUpError
from bilayer.solvers.contract import Equilibrium, Recorded, Saved, SpecimenPath, TargetMissedError
from bilayer.solvers.path import LoadStep
from bilayer.solvers.resuming import Unfinished
from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import StretchPair, stretch_of
from bilayer.specimen.specimen import Specimen

MILESTONE_DIMENSION = "prestretch"
"""The dimension of a result along which it grows."""

MeasureShape = Callable[[Specimen, PlanarMesh, StretchPair, NDArray[np.float64]], Measures]
"""Such as `bilayer.measures.milestone.measure`."""


@dataclass(frozen=True, eq=False)
class _Milestone:
    """The record of a milestone that is over.

    Parameters
    ----------
    state : MilestoneState
        The part that every solver has.
    own : Recorded or None
        The part of this solver alone; None if it is in the file of an earlier run.
    reason : str
        Why it was not reached, or an empty text.
    """

    state: MilestoneState
    own: Recorded | None
    reason: str = ""


class Recorder:
    """Keeps the milestones of a run, in memory and in a file.

    Parameters
    ----------
    specimen : Specimen
        Whose milestones.
    path : SpecimenPath
        Its load path.
    provenance : Provenance
        What makes the result.
    output : path-like or None
        The file; None: memory alone.
    earlier : Unfinished or None
        An earlier run that this one goes on from.
    measure_shape : callable, optional
        Takes what `measure` takes, which is called if it is left out.
    """

    def __init__(
        self,
        specimen: Specimen,
        path: SpecimenPath,
        provenance: Provenance,
        output: str | Path | None = None,
        earlier: Unfinished | None = None,
        measure_shape: MeasureShape | None = None,
    ) -> None:
        self._specimen, self._path, self._provenance = specimen, path, provenance
        self._output, self._earlier = output, earlier
        self._measure_shape = measure_shape or measure
        self._milestones: list[_Milestone] = []
        self._not_measured: list[str] = []
        self._saved: Saved = {}
        self._is_over = self._is_out_of_time = False
        if earlier is not None:
            self._milestones = [_Milestone(state, None) for state in earlier.states]
            self._not_measured = list(earlier.not_measured)
            self._saved = earlier.point.saved

    @property
    def tried(self) -> int:
        """Number of milestones that are over, reached or given up."""
        return len(self._milestones)

    def __call__(self, step: LoadStep[Any, Equilibrium]) -> None:
        """Keep a milestone that is reached, or the place where the path stopped."""
        if not step.ends_target:
            return
        with signals_put_off():
            self._milestones.append(self._collected(step))
            if step.is_at_target:
                self._saved = step.point.save()
            self._is_out_of_time = isinstance(step.failure, TimeIsUpError)
            self._is_over = step.index + 1 == step.count or not _goes_on(step.failure)
            on_first_rank(self._path.comm, lambda: self._finish(step.target))

    def result(self) -> xr.Dataset:
        """Return the dataset of the milestones so far; on the first rank."""
        states = [milestone.state for milestone in self._milestones]
        own = self._path.variables([milestone.own for milestone in self._milestones])
        result = build_result(
            self._specimen,
            self._path.mesh,
            states,
            self._provenance,
            stop_reason="; ".join(self._reasons) if self._is_over else INTERRUPTED,
            extra=own,
        )
        result.attrs["start"] = self._path.start
        if self._not_measured:
            result.attrs[NOT_MEASURED] = "; ".join(self._not_measured)
        if self._earlier is None:
            return result
        result.attrs["history"] += f"; {len(self._earlier.states)} milestones by an earlier run"
        return with_rows_of(self._earlier.result, result, len(self._earlier.states), own.data_vars)

    def _collected(self, step: LoadStep[Any, Equilibrium]) -> _Milestone:
        """Return the record of a milestone; on every rank."""
        point = step.point
        state = MilestoneState(
            point.position,
            converged=step.is_at_target,
            reached=max(point.stretch),
            energy=dict(point.energy),
            iterations=step.effort.iterations,
            load_steps=step.effort.load_steps,
            residual=point.residual,
            wall_time=step.wall_time,
            unstable_modes=point.unstable_modes,
            responses=dict(point.responses),
        )
        details = point.details() if step.is_at_target else None
        reason = _reason(step, self._specimen)
        return _Milestone(state, Recorded(step.effort, details), reason)

    def _finish(self, target: Milestone) -> None:
        """Measure the last milestone and write the file; on the first rank."""
        last = self._milestones[-1]
        measures = self._measured(target, last.state)
        state = replace(last.state, measures=measures)
        self._milestones[-1] = replace(last, state=state)
        if self._output is not None:
            write_result(self.result(), self._output, self._resume_point())

    def _measured(self, target: Milestone, state: MilestoneState) -> Measures:
        """Return the measures of a shape; NaN if they fail, which is noted."""
        if not state.converged:
            return Measures.undefined()
        try:
            stretch = stretch_of(target)
            return self._measure_shape(self._specimen, self._path.mesh, stretch, state.position)
        except Exception as error:  # whatever it is, the shape is there and is kept
            where = milestone_text(self._specimen, target)
            self._not_measured.append(f"{where}: {_words(error)}")
            return Measures.undefined()

    @property
    def _reasons(self) -> tuple[str, ...]:
        """Reasons of the milestones that were not reached."""
        earlier = () if self._earlier is None else self._earlier.point.reasons
        return (*earlier, *(done.reason for done in self._milestones if done.reason))

    def _resume_point(self) -> ResumePoint | None:
        """Return the point from which the run can be resumed, None if it is over.

        A milestone that was given up for lack of time is tried again.
        """
        if self._is_out_of_time:
            return ResumePoint(self.tried - 1, self._reasons[:-1], self._saved)
        return None if self._is_over else ResumePoint(self.tried, self._reasons, self._saved)


def leave_unmeasured(
    specimen: Specimen, mesh: PlanarMesh, stretch: StretchPair, position: NDArray[np.float64]
) -> Measures:
    """Return the measures of a shape that only leads to another one: NaN."""
    return Measures.undefined()


def with_rows_of(
    earlier: xr.Dataset, result: xr.Dataset, count: int, names: Iterable[Hashable]
) -> xr.Dataset:
    """Return a result with the first rows of some variables taken from an earlier one.

    Parameters
    ----------
    earlier : Dataset
        Of the run that computed these milestones.
    result : Dataset
        Of the run that went on; not changed.
    count : int
        Number of rows.
    names : iterable of str
        The variables; those that have no row per milestone, or are new, stay as they are.
    """
    joined = result.copy()
    for name in names:
        variable = result[name]
        if name in earlier and variable.dims[:1] == (MILESTONE_DIMENSION,):
            values = variable.values.copy()
            values[:count] = earlier[name].values[:count]
            joined[name] = (variable.dims, values, variable.attrs)
    return joined


def _goes_on(failure: Exception | None) -> bool:
    """Whether the path goes on to the next milestone."""
    return failure is None or isinstance(failure, TargetMissedError)


def _reason(step: LoadStep[Any, Equilibrium], specimen: Specimen) -> str:
    """Return the reason why a milestone was not reached, or an empty text."""
    if step.failure is None:
        return ""
    if isinstance(step.failure, TargetMissedError):
        return str(step.failure)
    where = place_words(specimen, step.point.milestone)
    return f"stopped at {where}: {_words(step.failure)}"


def _words(error: Exception) -> str:
    """Return an error in one line; its kind, too, if it is none of ours."""
    text = " ".join(str(error).split())
    own = type(error).__module__.split(".")[0] in ("bilayer", "dshell", "fenics_model")
    return text if own else f"{type(error).__name__}: {text}".removesuffix(": ")
