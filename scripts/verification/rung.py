"""A rung of the ladder: a case with a known answer, and the numbers a solver gives for it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from bilayer.errors import ComputationError

PASSED, MISSED, REPORTED = "passed", "missed", "reported"


@dataclass(frozen=True)
class Check:
    """One number beside the one it should be.

    Parameters
    ----------
    quantity : str
        What is measured, with its unit.
    measured, reference : float
        NaN if the computation failed.
    tolerance : float or None
        Allowed error; None: the number is reported and not judged.
    scale : float or None
        What the error is relative to; None: the reference.
    note : str
        Why there is no number, for a computation that failed.
    """

    quantity: str
    measured: float
    reference: float
    tolerance: float | None = None
    scale: float | None = None
    note: str = ""

    @property
    def error(self) -> float:
        scale = self.reference if self.scale is None else self.scale
        return abs(self.measured - self.reference) / abs(scale)

    @property
    def verdict(self) -> str:
        if self.tolerance is None:
            return REPORTED
        return PASSED if self.error <= self.tolerance else MISSED  # NaN is a miss


@dataclass(frozen=True)
class Rung:
    """A case of the ladder for one solver.

    Parameters
    ----------
    number : int
        Place in the ladder; solvers share it.
    solver : str
        Solver and model that are verified.
    title : str
        The case.
    source : str
        Where the reference comes from.
    checks : callable
        Computes the case: yields its checks.
    """

    number: int
    solver: str
    title: str
    source: str
    checks: Callable[[], Iterator[Check]]

    def climb(self) -> list[Check]:
        """Return the checks; what fails to compute is a miss that says why."""
        found = []
        try:
            for check in self.checks():
                found.append(check)
        except ComputationError as error:
            nan = float("nan")
            found.append(Check("the computation", nan, nan, 0.0, 1.0, f"failed: {error}"))
        return found
