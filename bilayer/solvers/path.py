"""The driver of a load path: through the targets in any order, telling whoever wants to know.

>>> for step in follow_path(path, [(1.03, 1.03), (1.06, 1.06), (1.03, 1.03)]):  # doctest: +SKIP
...     print(step.index, step.point.share)

The path knows nothing of files, measures and progress: these are observers, plain callables that
take a `LoadStep`. The caller of the generator holds each point while it is live.
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from bilayer.errors import ComputationError
from bilayer.runtime.time_limit import time_limit
from bilayer.solvers.contract import Path, PathPoint, TargetMissedError

Target = TypeVar("Target")
Point = TypeVar("Point", bound=PathPoint)


@dataclass(frozen=True, eq=False)
class LoadStep(Generic[Target, Point]):
    """A point of a path, while the path is there.

    Parameters
    ----------
    target : any
        The target on the way to which it is.
    index, count : int
        Place of that target, from 0, and the number of targets.
    point : PathPoint
        On the way, at the target, or where the path stopped.
    effort : Effort
        The work since the last target, failed attempts included.
    wall_time : float
        Seconds since the last target, without those of the observers.
    failure : Exception or None
        Why the target was not reached; None unless the path stopped here.
    """

    target: Target
    index: int
    count: int
    point: Point
    effort: Any
    wall_time: float
    failure: Exception | None = None

    @property
    def is_at_target(self) -> bool:
        """Whether the target is reached here."""
        return self.failure is None and self.point.share == 1

    @property
    def ends_target(self) -> bool:
        """Whether nothing more comes of this target: it is reached, or given up."""
        return self.is_at_target or self.failure is not None

    @property
    def fraction(self) -> float:
        """Part of all targets that is done, from 0 to 1."""
        return (self.index + self.point.share) / self.count


Observer = Callable[[LoadStep[Any, Any]], None]


def follow_path(
    path: Path[Target, Point],
    targets: Sequence[Target],
    observers: Sequence[Observer] = (),
    *,
    first: int = 0,
    limit: float = math.inf,
) -> Iterator[LoadStep[Target, Point]]:
    """Take a path through targets.

    Parameters
    ----------
    path : Path
        Where it is, it starts.
    targets : sequence
        In the order in which they are to be reached.
    observers : sequence of callable
        Each is told of every step, in this order, before the step is yielded.
    first : int
        The target to begin with; those before it are done.
    limit : float
        Seconds for each target; the path ends where they are over.

    Yields
    ------
    LoadStep
        Each point; if a target cannot be reached, the one where the path stopped. On a
        `TargetMissedError` the next target follows; after another `ComputationError`, or when there
        is no more memory, it is the last.
    """
    for index in range(first, len(targets)):
        for step in _steps_to(path, targets, index, limit):
            for observer in observers:
                observer(step)
            yield step
            if step.failure is not None and not isinstance(step.failure, TargetMissedError):
                return


def _steps_to(
    path: Path[Target, Point], targets: Sequence[Target], index: int, limit: float
) -> Iterator[LoadStep[Target, Point]]:
    """Yield the steps to one target."""
    target, count = targets[index], len(targets)
    effort: Any = None
    seconds = 0.0
    points = path.approach(target)
    while True:
        failure: Exception | None = None
        begun = time.perf_counter()
        try:
            with time_limit(limit - seconds):
                point = next(points)
        except StopIteration:
            return
        except (ComputationError, MemoryError) as error:
            failure, point = error, path.stopped()
        seconds += time.perf_counter() - begun
        effort = point.effort if effort is None else effort + point.effort
        yield LoadStep(target, index, count, point, effort, seconds, failure)
        if failure is not None:
            return


def run_path(
    path: Path[Target, Point],
    targets: Sequence[Target],
    observers: Sequence[Observer] = (),
    *,
    first: int = 0,
    limit: float = math.inf,
) -> None:
    """Take a path through targets for its observers alone; see `follow_path`."""
    for _ in follow_path(path, targets, observers, first=first, limit=limit):
        pass
