"""The parameter with which a result fits a scan best: solved anew, laid on, by bounded search.

The parameter is the prestretch, or any other of `bilayer.solvers.parameters` at the milestone that
fits best, such as a thickness or a constant of a law.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from bilayer.errors import ComputationError, InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import result_mesh, result_specimen
from bilayer.results.table import stretches
from bilayer.scan.cloud import Cloud
from bilayer.scan.comparison import ScanMatch, best_match, compare_scan, match_near
from bilayer.scan.profile import Profile, ProfileMatch, compare_profile
from bilayer.solvers.parameters import changed, parameter_value
from bilayer.solvers.registry import solve
from bilayer.solvers.rerun import result_settings
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.settings import check_plain
from bilayer.specimen.specimen import Specimen

Target = Cloud | Profile
Match = ScanMatch | ProfileMatch
REACH = 0.3
"""Of a parameter that is not the prestretch: it is sought so far to either side, over its value."""
WIDEN = 0.02
"""How far beyond the first or last milestone the prestretch is sought."""
CLOSE = 2e-3
"""The search ends when the parameter is known to this part of its range."""


@dataclass(frozen=True, eq=False)
class ScanFit:
    """What fits a scan best.

    Parameters
    ----------
    parameter : str
        Which.
    value, given : float
        The best value, and that of the result's nearest milestone, in SI units.
    bounds : (float, float)
        Within which it was sought.
    match : ScanMatch or ProfileMatch
        The scan laid onto the best shape.
    result : Dataset
        That shape as a result.
    tried : dict of float to float
        The rms distance that counts (`ScanMatch.cost`), m, by value.
    """

    parameter: str
    value: float
    given: float
    bounds: tuple[float, float]
    match: Match
    result: xr.Dataset
    tried: dict[float, float]

    @property
    def is_at_bound(self) -> bool:
        """Whether a better value may lie beyond."""
        low, high = self.bounds
        return min(self.value - low, high - self.value) < 2 * CLOSE * (high - low)


def fit_to_scan(
    result: xr.Dataset, scan: Target, parameter: str = "prestretch", *, trust: bool = False
) -> ScanFit:
    """Find the value of a parameter with which the shape fits a scan best.

    Parameters
    ----------
    result : Dataset
        Its solver, settings and mesh are used; its shapes start the others.
    scan : Cloud or Profile
        Of the part.
    parameter : str
        "prestretch", "prestretch.x", or another of `bilayer.solvers.parameters`, such as
        "substrate.thickness" or "kirigami.material.c10".
    trust : bool
        Allow settings that could run code or write files. They come from the result's file.

    Raises
    ------
    InputError
        There is no such parameter, or the result holds no shape.
    ComputationError
        No shape was found but the first.

    Examples
    --------
    >>> import bilayer
    >>> found = bilayer.fit_to_scan(result, bilayer.read_cloud("part.stl"))  # doctest: +SKIP
    >>> found.value, found.match.rms  # doctest: +SKIP
    """
    from scipy.optimize import minimize_scalar  # slow to load

    known = along_milestones(result)
    known = known.isel(prestretch=np.flatnonzero(known["converged"].values == 1))
    if known.sizes["prestretch"] == 0:
        raise InputError("result: has no milestone that was reached")
    settings = result_settings(known)
    if not trust:
        check_plain(settings)
    specimen, mesh = result_specimen(known), result_mesh(known)
    matches = _laid(known, scan)
    best = best_match(matches)
    x, y = stretches(known)[best]
    stretch = (float(x), float(y))
    given = parameter_value(specimen, stretch, parameter)
    bounds = _bounds(known, parameter, given, best)
    search = _Search(known, scan, specimen, mesh, settings, stretch, parameter, matches[best])
    minimize_scalar(
        search.cost, bounds=bounds, method="bounded",
        options={"xatol": CLOSE * (bounds[1] - bounds[0])},
    )  # fmt: skip
    if search.best is None:
        low, high = bounds
        raise ComputationError(f"{parameter}: no shape was found from {low:g} to {high:g}")
    value, match, shape = search.best
    return ScanFit(parameter, value, given, bounds, match, shape, search.tried)


def _laid(result: xr.Dataset, scan: Target) -> Sequence[Match]:
    """Return what is measured laid onto the shape of each milestone."""
    if isinstance(scan, Profile):
        return compare_profile(result, scan)
    return compare_scan(result, scan)


def _laid_near(result: xr.Dataset, scan: Target, near: Match) -> Match:
    """Return what is measured laid onto the only shape of a result, from where it was before."""
    if isinstance(scan, Cloud) and isinstance(near, ScanMatch):
        return match_near(result, scan, near.motion)
    return _laid(result, scan)[0]


def _bounds(result: xr.Dataset, parameter: str, given: float, best: int) -> tuple[float, float]:
    """Return where a parameter is sought: between the neighbours of the best milestone."""
    if not parameter.startswith("prestretch"):
        if given == 0:
            raise InputError(f"--fit {parameter}: is 0, expected one that is not")
        return tuple(sorted(((1 - REACH) * given, (1 + REACH) * given)))  # type: ignore[return-value]
    values = np.unique(result["prestretch"].values)
    place = int(np.argmin(np.abs(values - result["prestretch"].values[best])))
    low = values[place - 1] if place > 0 else max(1.0, values[0] - WIDEN)
    high = values[place + 1] if place + 1 < len(values) else values[-1] + WIDEN
    return float(low), float(high)


class _Search:
    """The cost of a value of the parameter; it keeps the best shape."""

    def __init__(
        self,
        result: xr.Dataset,
        scan: Target,
        specimen: Specimen,
        mesh: PlanarMesh,
        settings: Any,
        stretch: StretchPair,
        parameter: str,
        near: Match,
    ) -> None:
        self._result, self._scan, self._near = result, scan, near
        self._specimen, self._mesh, self._settings = specimen, mesh, settings
        self._stretch, self._parameter = stretch, parameter
        self._given = parameter_value(specimen, stretch, parameter)
        self.best: tuple[float, Match, xr.Dataset] | None = None
        self.tried: dict[float, float] = {}

    def cost(self, value: float) -> float:
        """Return the cost of a value, m; infinite if there is no shape."""
        change = float(value) - self._given
        specimen, stretch = changed(self._specimen, self._stretch, self._parameter, change)
        shape = solve(
            specimen.with_milestones([stretch]),
            self._result.attrs["solver"],
            self._settings,
            mesh=self._mesh,
            start=self._result,
        )
        if not shape["converged"].values[0]:
            return float("inf")
        match = _laid_near(shape, self._scan, self._near)
        self.tried[float(value)] = match.cost
        if self.best is None or match.cost < self.best[1].cost:
            self.best = float(value), match, shape
        return match.cost


def scan_fit_report(fit: ScanFit) -> str:
    """Return a fit in two lines."""
    text = (
        f"{fit.parameter} = {fit.value:.6g} fits best (rms {1e3 * fit.match.rms:.3f} mm); "
        f"{fit.given:.6g} in the result, {len(fit.tried)} shapes from {fit.bounds[0]:.6g} to "
        f"{fit.bounds[1]:.6g}"
    )
    if fit.is_at_bound:
        text += "\nIt lies at a bound: a better value may lie beyond."
    return text
