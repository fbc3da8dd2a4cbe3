"""The size of the next load step, from how many corrections the last one took."""

from dataclasses import dataclass, replace
from math import ceil, sqrt


@dataclass(frozen=True)
class StepControl:
    """An adaptive step: grows or shrinks toward a target number of iterations, halves on failure.

    It depends on counts of corrections alone, so every rank and every repetition takes the same
    steps.

    Parameters
    ----------
    size : float
        The next step's size.
    smallest, largest : float
        Its bounds.
    target_iterations : int
        Iterations that a step should take.
    failures : int
        Failed steps since the last converged one.
    """

    size: float
    smallest: float
    largest: float
    target_iterations: int
    failures: int = 0

    def after_success(self, iterations: int) -> "StepControl":
        """Return the control after a converged step: size times sqrt(target / iterations).

        One step changes the size by a factor of 1/2 to 2 at most.
        """
        factor = min(2.0, max(0.5, sqrt(self.target_iterations / max(iterations, 1))))
        size = min(self.largest, max(self.smallest, factor * self.size))
        return replace(self, size=size, failures=0)

    def after_failure(self, attempted: float) -> "StepControl":
        """Return the control after a failed step of the size `attempted`: half of that."""
        return replace(self, size=attempted / 2, failures=self.failures + 1)

    @property
    def is_exhausted(self) -> bool:
        """Whether the step was cut below the smallest one."""
        return self.size < self.smallest

    def step_toward(self, remaining: float) -> float:
        """Return the step to take if a milestone lies `remaining` ahead.

        The rest of the way is divided evenly, so the milestone is hit without a sliver of a step.
        """
        steps = ceil(remaining / self.size * (1 - 1e-9))
        return remaining / max(steps, 1)
