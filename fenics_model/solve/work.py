"""What the linear algebra of a run takes: factorisations, and the seconds of each part."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Work:
    """CPU seconds of this process, and counts.

    Parameters
    ----------
    factorisations : int
        Of tangents, those for the inertia included.
    assembly : float
        Residuals and tangents, s.
    factorisation : float
        Factorisations and the solutions with them, s.
    total : float
        Everything, s.
    """

    factorisations: int = 0
    assembly: float = 0.0
    factorisation: float = 0.0
    total: float = 0.0


class Stopwatch:
    """Adds up the work of whatever it is handed to."""

    def __init__(self) -> None:
        self._since = time.process_time()
        self._work = Work()

    @contextmanager
    def assembling(self) -> Iterator[None]:
        """Measure an assembly."""
        begin = time.process_time()
        try:
            yield
        finally:
            spent = self._work.assembly + time.process_time() - begin
            self._work = replace(self._work, assembly=spent)

    @contextmanager
    def solving(self) -> Iterator[None]:
        """Measure a solution: what of it is not assembly is factorisation."""
        begin, assembly = time.process_time(), self._work.assembly
        try:
            yield
        finally:
            assembling = self._work.assembly - assembly
            spent = self._work.factorisation + time.process_time() - begin - assembling
            self._work = replace(self._work, factorisation=spent)

    def count_factorisation(self) -> None:
        """Note that a tangent is about to be factorised."""
        self._work = replace(self._work, factorisations=self._work.factorisations + 1)

    def taken(self) -> Work:
        """Return the work since the last call, and begin anew."""
        now = time.process_time()
        work = replace(self._work, total=now - self._since)
        self._since, self._work = now, Work()
        return work
