"""A stopwatch for the linear algebra of a run: factorisations, and the seconds of each part."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from fenics_model.solve.effort import Work


class Stopwatch:
    """Adds up the work of whatever it is handed to."""

    def __init__(self) -> None:
        self._since, self._work = time.process_time(), Work()

    @contextmanager
    def time_assembly(self) -> Iterator[None]:
        """Measure an assembly."""
        begin = time.process_time()
        try:
            yield
        finally:
            seconds = self._work.assembly + time.process_time() - begin
            self._work = replace(self._work, assembly=seconds)

    @contextmanager
    def time_solution(self) -> Iterator[None]:
        """Measure a solution: what of it is not assembly is factorisation."""
        begin, assembly = time.process_time(), self._work.assembly
        try:
            yield
        finally:
            in_assembly = self._work.assembly - assembly
            seconds = self._work.factorisation + time.process_time() - begin - in_assembly
            self._work = replace(self._work, factorisation=seconds)

    def count_factorisation(self) -> None:
        """Note that a tangent is about to be factorised."""
        self._work = replace(self._work, factorisations=self._work.factorisations + 1)

    def count_correction(self) -> None:
        """Note a correction with a factor that is there."""
        self._work = replace(self._work, corrections=self._work.corrections + 1)

    def restart(self) -> None:
        """Begin anew, from now on."""
        self._since, self._work = time.process_time(), Work()

    def take(self) -> Work:
        """Return the work since the last call or restart, and begin anew."""
        work = replace(self._work, total=time.process_time() - self._since)
        self.restart()
        return work
