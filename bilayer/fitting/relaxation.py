"""A Prony series from a relaxation test: stress over time at a stretch that is held.

The shares are non-negative least squares for given times, and the times those with the least
residual (variable projection). The number of terms is that with the least AICc.
"""

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError, InputError
from bilayer.fitting.measurement import STRESS_WORDS, chosen_column, read_table, unit_of_stress
from bilayer.specimen.relaxation import PronySeries
from bilayer.specimen.units import in_si
from bilayer.validation import not_negative, whole

Array = NDArray[np.float64]

TIME_WORDS = (r"\btime\b", r"^t\b", r"\bseconds?\b")
MOST_TERMS = 6
LEAST_POINTS = 6
AT_BOUND = 1.01
"""A term whose time is within this factor of the shortest or longest allowed is not determined."""
APART = 1.5
"""Times of the terms that are nearer to each other than by this factor are one term."""


@dataclass(frozen=True)
class Relaxation:
    """A relaxation test.

    Parameters
    ----------
    name : str
        Of the file.
    time : ndarray, shape (n,)
        Since the stretch was reached, s.
    stress : ndarray, shape (n,)
        Pa, nominal or true: the stretch is held.
    """

    name: str
    time: Array
    stress: Array

    def __post_init__(self) -> None:
        if len(self.time) < LEAST_POINTS:
            raise InputError(
                f"{self.name}: has {len(self.time)} points, expected at least {LEAST_POINTS}"
            )
        if not (np.isfinite(self.time).all() and np.isfinite(self.stress).all()):
            raise InputError(f"{self.name}: expected finite numbers")
        if (self.time < 0).any() or (np.diff(self.time) <= 0).any():
            raise InputError(f"{self.name}: expected times from 0 on that rise")
        if not (self.stress > 0).all():
            raise InputError(f"{self.name}: expected stresses above 0")


@dataclass(frozen=True)
class RelaxationFit:
    """A Prony series that was fitted, and how well.

    Parameters
    ----------
    series : PronySeries
        Its shares are of the stress after an infinitely fast stretching.
    instantaneous : float
        That stress, Pa.
    test : Relaxation
        What it was fitted to.
    ramp : float
        Time of the stretching, s.
    rms : float
        Root of the mean square of the residuals, over the first stress.
    aicc : float
        Akaike's criterion with the correction for few points.
    """

    series: PronySeries
    instantaneous: float
    test: Relaxation
    ramp: float
    rms: float
    aicc: float

    def stress(self, time: Array) -> Array:
        """Return the stress at times since the stretch was reached, Pa."""
        values = _terms(time, self.series.times, self.ramp) @ self.series.shares
        return np.asarray(self.instantaneous * (self.series.relaxed_share + values))


def read_relaxation(
    path: str | Path, time_column: str | None = None, stress_column: str | None = None
) -> Relaxation:
    """Read a relaxation test: a table with a column of times and one of stresses.

    Parameters
    ----------
    path : path-like
        As for `bilayer.read_measurement`.
    time_column, stress_column : str, optional
        Names of the columns. Left out: those with "time" and "stress" in their names. Units stand
        at the end of the names: time_s, time (min); s and Pa without one.

    Raises
    ------
    InputError
        The file cannot be read, or a column is not found.
    """
    source = Path(path)
    names, table = read_table(source)
    time = chosen_column(source, names, time_column, TIME_WORDS, "time")
    stress = chosen_column(source, names, stress_column, STRESS_WORDS, "stress")
    return Relaxation(
        source.name,
        table[:, names.index(time)] * _unit_of_time(time),
        table[:, names.index(stress)] * unit_of_stress(stress),
    )


def fit_relaxation(test: Relaxation, terms: int | None = None, ramp: float = 0.0) -> RelaxationFit:
    """Return the Prony series that comes nearest to a relaxation test.

    Parameters
    ----------
    test : Relaxation
        Stress over time.
    terms : int, optional
        How many terms; the number with the least AICc, up to 6, if left out.
    ramp : float
        Time in which the stretch was reached, s. The stress is taken to rise linearly meanwhile,
        so a term has relaxed by (1 - exp(-ramp / tau)) tau / ramp when the time begins.

    Raises
    ------
    InputError
        There are too few points.
    ComputationError
        No series with so many terms fits.

    Examples
    --------
    >>> import numpy as np
    >>> time = np.geomspace(0.1, 1000, 60)
    >>> stress = 1e4 * (0.3 + 0.5 * np.exp(-time / 2) + 0.2 * np.exp(-time / 50))
    >>> found = fit_relaxation(Relaxation("made", time, stress))
    >>> [(round(share, 3), round(time, 2)) for share, time in found.series.terms]
    [(0.5, 2.0), (0.2, 50.0)]
    """
    ramp = not_negative("ramp", ramp, "s")
    counts = range(1, MOST_TERMS + 1)
    if terms is not None:
        counts = range(whole("terms", terms, at_least=1), terms + 1)
    fits = [fit for count in counts if (fit := _fit(test, count, ramp)) is not None]
    if not fits:
        asked = "" if terms is None else f" of {terms} terms"
        raise ComputationError(
            f"{test.name}: no Prony series{asked} fits, expected fewer terms or a longer test"
        )
    return min(fits, key=lambda fit: fit.aicc)


def _fit(test: Relaxation, count: int, ramp: float) -> RelaxationFit | None:
    """Return the best fit with so many terms; None if the test does not determine them all."""
    from scipy.optimize import least_squares  # slow to load

    points, unknowns = len(test.time), 2 * count + 1
    if points <= unknowns + 1:
        return None
    first = test.time[test.time > 0][0]
    low, high = math.log(first / 3), math.log(3 * test.time[-1])
    start = np.linspace(low, high, count + 2)[1:-1]
    found = least_squares(
        lambda log: _residuals(test, np.exp(log), ramp)[0], start, bounds=(low, high),
        xtol=1e-12, ftol=1e-13, gtol=1e-13, max_nfev=400,
    )  # fmt: skip
    times = np.sort(np.exp(found.x))
    rest, constants = _residuals(test, times, ramp)
    is_at_bound = times[0] < AT_BOUND * math.exp(low) or times[-1] > math.exp(high) / AT_BOUND
    if is_at_bound or (constants[1:] <= 0).any() or (times[1:] < APART * times[:-1]).any():
        return None
    whole_stress = constants.sum()
    series = PronySeries(tuple(zip(constants[1:] / whole_stress, times, strict=True)))
    square = float(np.mean(rest**2))
    aicc = points * math.log(max(square, 1e-30)) + 2 * unknowns
    aicc += 2 * unknowns * (unknowns + 1) / (points - unknowns - 1)
    return RelaxationFit(
        series, float(whole_stress * test.stress[0]), test, ramp, math.sqrt(square), aicc
    )


def _residuals(test: Relaxation, times: Array, ramp: float) -> tuple[Array, Array]:
    """Return the residuals over the first stress, and (g_inf, g_i) over it, of the best shares."""
    from scipy.optimize import nnls

    columns = np.column_stack([np.ones_like(test.time), _terms(test.time, times, ramp)])
    measured = test.stress / test.stress[0]
    constants, _ = nnls(columns, measured)
    return columns @ constants - measured, constants


def _terms(time: Array, times: Array, ramp: float) -> Array:
    """Return exp(-t / tau) of each term, less what has relaxed on the ramp, (n, terms)."""
    decay = np.exp(-time[:, None] / times)
    share = ramp / times
    left = np.where(share > 0, -np.expm1(-share) / np.where(share > 0, share, 1.0), 1.0)
    return np.asarray(decay * left)


def relaxation_report(fit: RelaxationFit, name: str) -> str:
    """Return the lines of a fit, ending in a table [materials.NAME]."""
    series, test = fit.series, fit.test
    lines = [
        f"of {test.name}: {len(test.time)} points, {test.time[0]:g} to {test.time[-1]:g} s",
        f"instantaneous stress {fit.instantaneous / 1e3:.4g} kPa, "
        f"relaxed {fit.instantaneous * series.relaxed_share / 1e3:.4g} kPa "
        f"({100 * series.relaxed_share:.1f} %)",
        *(f"  g = {share:.4f}, tau = {time:.4g} s" for share, time in series.terms),
        f"rms {100 * fit.rms:.2f} % of the first stress",
    ]
    if fit.ramp == 0:
        lines.append("The stretch counts as reached at once; --ramp says how long it took.")
    terms = ", ".join(f'[{share:.6g}, "{time:.6g} s"]' for share, time in series.terms)
    return "\n".join([*lines, "", f"[materials.{name}]", f"relaxation = [{terms}]"])


def relaxation_record(fit: RelaxationFit) -> dict[str, Any]:
    """Return a fit as a record of numbers in SI units."""
    return {
        "relaxation": [list(term) for term in fit.series.terms],
        "relaxed_share": fit.series.relaxed_share,
        "instantaneous_stress": fit.instantaneous,
        "rms": fit.rms,
        "aicc": fit.aicc,
        "points": len(fit.test.time),
        "ramp": fit.ramp,
    }


def _unit_of_time(name: str) -> float:
    """Return the unit at the end of a time's name, s."""
    unit = re.search(r"(?:[_\s(\[/])(ms|s|min|h)[)\]]?\s*$", name)
    if unit is None:
        return 1.0
    return float(in_si("time", {"unit": f"1 {unit[1]}"}, {"unit": "s"})["unit"])
