"""The state of a path, as arrays from which any number of ranks can continue."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bilayer.results.start_shapes import StartShapes
from bilayer.solvers.contract import Saved
from bilayer.specimen.load import Milestone
from fenics_model.path.continuation import Continuation
from fenics_model.path.guide import Guide
from fenics_model.path.load_schedule import LoadSchedule
from fenics_model.path.predictor import Predictor
from fenics_model.solid.numbering import Numbering
from fenics_model.solid.state import State

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SavedPath:
    """All that a path needs to go on.

    Parameters
    ----------
    targets : sequence of milestones
        Those so far.
    times : sequence of float
        Of each, s after the release.
    equilibria : sequence of (float, State)
        Parameters and states that the predictor knows, the last one last.
    step, failures : float, int
        Of the step control.
    defects : sequence of (float, array of float)
        Of the guide, by parameter.
    is_trusted : bool
        Whether the guide is.
    rejected : sequence of (float, str)
        Shapes that were not followed, see `Guide.rejected`.
    shapes : StartShapes or None
        The initial guesses.
    start : str
        Their source.
    """

    targets: Sequence[Milestone]
    times: Sequence[float]
    equilibria: Sequence[tuple[float, State]]
    step: float
    failures: int
    defects: Sequence[tuple[float, Array]]
    is_trusted: bool
    rejected: Sequence[tuple[float, str]]
    shapes: StartShapes | None
    start: str

    @classmethod
    def of(
        cls,
        continuation: Continuation,
        guide: Guide,
        loads: LoadSchedule,
        shapes: StartShapes | None,
        start: str,
    ) -> "SavedPath":
        """Return the state of a path."""
        return cls(
            loads.targets,
            loads.times,
            list(continuation.predictor.known),
            continuation.control.size,
            continuation.control.failures,
            list(guide.defects),
            guide.is_trusted,
            list(guide.rejected),
            shapes,
            start,
        )

    def restore(self, continuation: Continuation, guide: Guide) -> None:
        """Put continuation and guide where they were."""
        continuation.predictor = Predictor(self.equilibria)
        continuation.control = replace(continuation.control, size=self.step, failures=self.failures)
        guide.restore(self.defects, self.is_trusted, self.rejected)

    def as_arrays(self, numbering: Numbering) -> dict[str, NDArray[np.generic]]:
        """Return it by name, the same on every rank; what is empty is left out."""
        arrays = {
            "targets": np.array(self.targets),
            "target_times": np.array(self.times) if any(self.times) else np.array([]),
            "equilibrium_parameter": np.array([t for t, _ in self.equilibria]),
            "equilibrium": _stack([numbering.gather(s.values) for _, s in self.equilibria]),
            "step": np.array([self.step]),
            "failures": np.array([self.failures]),
            "defect_parameter": np.array([t for t, _ in self.defects]),
            "defect": _stack([numbering.gather(change) for _, change in self.defects]),
            "guide_is_trusted": np.array([int(self.is_trusted)]),
            "left_parameter": np.array([t for t, _ in self.rejected]),
            "left_reason": np.array([reason for _, reason in self.rejected], dtype=str),
            "start": np.array([self.start]),
        }
        if self.shapes is not None:
            arrays |= {
                "shape_stretch": self.shapes.stretches,
                "shape_position": self.shapes.positions,
                "shape_last": np.array([self.shapes.last]),
            }
        return {name: array for name, array in arrays.items() if array.size}

    @classmethod
    def from_arrays(cls, saved: Saved, numbering: Numbering) -> "SavedPath":
        """Return the state from the arrays of `as_arrays`, on any number of ranks."""

        def pairs(name: str) -> list[tuple[float, Array]]:
            parameters = saved.get(f"{name}_parameter", np.array([]))
            values = (numbering.spread(values) for values in saved.get(name, ()))
            return [(float(t), found) for t, found in zip(parameters, values, strict=True)]

        shapes = None
        if "shape_stretch" in saved:
            last = int(saved["shape_last"][0])
            shapes = StartShapes(saved["shape_stretch"], saved["shape_position"], last)
        reasons = zip(saved.get("left_parameter", ()), saved.get("left_reason", ()), strict=True)
        targets = [tuple(float(value) for value in row) for row in saved.get("targets", ())]
        return cls(
            targets,
            [float(time) for time in saved.get("target_times", np.zeros(len(targets)))],
            [(t, State(values)) for t, values in pairs("equilibrium")],
            float(saved["step"][0]),
            int(saved["failures"][0]),
            pairs("defect"),
            bool(saved["guide_is_trusted"][0]),
            [(float(t), str(reason)) for t, reason in reasons],
            shapes,
            str(saved["start"][0]),
        )


def _stack(rows: Sequence[Array]) -> Array:
    return np.stack(rows) if rows else np.empty((0, 0))
