"""The paper's specimen with a substrate that relaxes, by either solver. SI units."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from bilayer import MeshSize, Specimen, generate_mesh, paper_specimen, solve
from bilayer.results.comparison import compare
from bilayer.specimen.relaxation import PronySeries
from bilayer.specimen.schedule import Schedule
from verification.rung import Check

SERIES = PronySeries(((0.4, 0.5), (0.3, 20.0)))
STRETCH, HOLD, SETTLED = 1.06, 10.0, 1e6
TIMES = (0.0, 1.0, 10.0, 100.0)
COMPARED_SIZE, STEPS = 0.004, 4
MOST_APART, MOST_COST = 0.005, 1.3


def sheet_of(size: float) -> Specimen:
    return replace(paper_specimen(), mesh=MeshSize(size)).with_milestones([STRETCH])


def relaxing(sheet: Specimen, times: Sequence[float], hold: float) -> Specimen:
    slow = sheet.with_layer("substrate", relaxation=SERIES)
    return replace(slow, schedule=Schedule(tuple(times), hold, STEPS))


def softened(sheet: Specimen) -> Specimen:
    """The sheet with the relaxed constants of its substrate."""
    law, left = sheet.layer("substrate").material, SERIES.relaxed_share
    softer = replace(law, c10=left * law.c10, c01=left * law.c01, d1=law.d1 / left)
    return sheet.with_layer("substrate", material=softer)


def limits(solver: str, size: float) -> Iterator[Check]:
    """Time 0 against the instantaneous laws, long after against the relaxed ones."""
    sheet = sheet_of(size)
    mesh, radius = generate_mesh(sheet), sheet.characteristic_length

    def shapes(specimen):
        return solve(specimen, solver, mesh=mesh)["position"].values

    def apart(one, other):
        return float(np.sqrt(np.mean(np.sum((one - other) ** 2, axis=-1)))) / radius

    first, last = shapes(relaxing(sheet, (0.0, SETTLED), 0.0))
    at_once, relaxed = shapes(sheet)[0], shapes(softened(sheet))[0]
    yield Check("time 0: shape of the instantaneous laws / R", apart(first, at_once), 0.0, 1e-6, 1)
    yield Check("long after: shape of the relaxed laws / R", apart(last, relaxed), 0.0, 1e-6, 1)
    yield Check("distance of the two shapes / R", apart(first, last), float("nan"))


@dataclass(frozen=True)
class Costs:
    """Of a step of time over the release, by iterations with their factors, and by CPU time."""

    factors: float
    seconds: float


class Clock:
    """An observer that takes the CPU time of each load step."""

    def __init__(self) -> None:
        self.seconds: list[float] = []
        self._last = time.process_time()

    def __call__(self, step) -> None:
        now = time.process_time()
        self.seconds.append(now - self._last)
        self._last = now


def costs(result: xr.Dataset, clock: Clock) -> Costs:
    """Each step counts its unstable modes with one factor more, and so does the release."""
    iterations, steps = (result[name].values for name in ("iterations", "load_steps"))
    released, *stepped = clock.seconds
    a_step = iterations[1:].sum() / steps[1:].sum()
    return Costs((a_step + 1) / (iterations[0] + 1), float(np.mean(stepped) / released))


def solvers_apart() -> Iterator[Check]:
    """Both solvers on one mesh, without and with a hold, and what a step of time costs."""
    sheet = sheet_of(COMPARED_SIZE)
    mesh = generate_mesh(sheet)
    solve(relaxing(sheet, (0.0,), HOLD), "fenics", mesh=mesh)  # so that all is compiled
    for hold in (0.0, HOLD):
        slow, clock = relaxing(sheet, TIMES, hold), Clock()
        solid = solve(slow, "fenics", mesh=mesh, observers=[clock])
        compared = compare(solid, solve(slow, "dshell", mesh=mesh))
        for at, found in zip(TIMES, compared["rms_distance_over_radius"].values, strict=True):
            case = f"hold {hold:g} s, {at:g} s after"
            yield Check(f"{case}: the shell / R", float(found), 0.0, MOST_APART, 1.0)
        cost = costs(solid, clock)
        case = f"hold {hold:g} s, a step of time over the release"
        yield Check(f"{case}: factorisations", cost.factors, 0.0, MOST_COST, 1.0)
        yield Check(f"{case}: CPU time", cost.seconds, 0.0, MOST_COST, 1.0)
