"""A scan against the shapes of a result: which milestone it is, and how far it is away."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.geometry.surface import Surface
from bilayer.results.milestones import along_milestones
from bilayer.results.released_shapes import MM_PER_M, Shape, released_shapes
from bilayer.results.schema import result_mesh
from bilayer.scan.cloud import Cloud
from bilayer.scan.placing import Motion, outlier_limit, placed, refined
from bilayer.scan.samples import Samples, at_most, even_samples

Array = NDArray[np.float64]
SAMPLES = 20_000
"""Points that stand for a shape."""
BACK = 2
"""Every second of them is looked at from the shape to the scan."""
RANKED = 10_000
"""Points of the scan by which milestones are ranked; the best one gets all of them."""
MEASURED: Mapping[str, Callable[[Array], float]] = {
    "rms": lambda distances: float(np.sqrt(np.mean(distances**2))),
    "mean": lambda distances: float(np.mean(distances)),
    "95 %": lambda distances: float(np.quantile(distances, 0.95)),
    "largest": lambda distances: float(np.max(distances)),
}
"""What is told of the distances one way, m."""


@dataclass(frozen=True)
class ScanMatch:
    """A scan laid onto the shape of one milestone.

    Parameters
    ----------
    title : str
        The milestone.
    motion : Motion
        What lays the scan onto the shape, m.
    distances : ndarray, shape (n,)
        Of the scan's points from the shape, positive on its upper side, m; outliers among them.
    outliers : ndarray of bool, shape (n,)
        Which of them do not count.
    back : ndarray, shape (m,)
        Distances of points of the shape from the nearest point of the scan, m.
    spacing : float
        About the distance between neighbours in the scan, m.
    diagonal : float
        Of the box around the shape, m.
    milestone : int
        Its place in the result.
    """

    title: str
    motion: Motion
    distances: Array
    outliers: NDArray[np.bool_]
    back: Array
    spacing: float
    diagonal: float
    milestone: int

    @property
    def inner(self) -> Array:
        """Absolute distances of the points that count, m."""
        return np.abs(self.distances[~self.outliers])

    @property
    def rms(self) -> float:
        """Root mean square of the distances that count, m."""
        return float(np.sqrt(np.mean(self.inner**2)))

    @property
    def reach(self) -> float:
        """Distance within which a place of the shape has a point of the scan beside it, m."""
        return 3 * self.spacing + 3 * self.rms

    @property
    def coverage(self) -> float:
        """Share of the shape that has a point of the scan beside it."""
        return float(np.mean(self.back <= self.reach))

    @property
    def ways(self) -> dict[str, Array]:
        """Distances from the scan to the shape, and back from where the scan covers it, m."""
        covered = self.back[self.back <= self.reach]
        ways = {"scan to shape": self.inner, "shape to scan": covered}
        return {way: distances for way, distances in ways.items() if len(distances)}

    @property
    def cost(self) -> float:
        """By which milestones are ranked, m: both ways, the farthest sixth left out."""
        ways = [np.sort(np.abs(self.distances)), np.sort(self.back)]
        kept = [way[: math.ceil(5 * len(way) / 6)] for way in ways]
        return float(np.sqrt(sum(np.mean(way**2) for way in kept) / 2))


def compare_scan(result: xr.Dataset, scan: Cloud) -> list[ScanMatch]:
    """Lay a scan onto the shape of each milestone.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`. Its `position` is what the scan is held against.
    scan : Cloud
        Of the part.

    Returns
    -------
    list of ScanMatch
        One for each milestone that has a shape; the one of the least `cost` fits best.

    Raises
    ------
    InputError
        The result holds no shape.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> scan = bilayer.Cloud("itself", result["position"].values[0])
    >>> match, = bilayer.compare_scan(result, scan)
    >>> match.rms < 1e-3
    True
    """
    reached = along_milestones(result)
    shapes = released_shapes(reached, result_mesh(reached))
    surfaces = [even_samples(_in_metres(shape.surface), SAMPLES) for shape in shapes]
    some = at_most(RANKED, scan.points)
    matches = [
        _laid(shape, surface, some, placed(some, surface))
        for shape, surface in zip(shapes, surfaces, strict=True)
    ]
    best = best_match(matches)
    matches[best] = _laid(shapes[best], surfaces[best], scan.points, matches[best].motion)
    return matches


def match_near(result: xr.Dataset, scan: Cloud, motion: Motion) -> ScanMatch:
    """Lay a scan onto the only shape of a result, from a motion that nearly does so.

    Parameters
    ----------
    result : Dataset
        With one milestone, that has a shape.
    scan : Cloud
        Of the part.
    motion : Motion
        What laid it onto a shape that differs by little.
    """
    reached = along_milestones(result)
    (shape,) = released_shapes(reached, result_mesh(reached))
    surface = even_samples(_in_metres(shape.surface), SAMPLES)
    return _laid(shape, surface, scan.points, refined(motion, scan.points, surface))


def size_doubt(result: xr.Dataset, scan: Cloud) -> str:
    """Return a line if a scan is far larger or smaller than all shapes of a result, or "".

    A tiny scan lies near any surface, so its distances say nothing.
    """
    reached = along_milestones(result)
    shapes = released_shapes(reached, result_mesh(reached))
    sizes = [_diagonal(_in_metres(shape.surface).points) for shape in shapes]
    scanned = _diagonal(scan.points)
    if min(sizes) / SAME_SIZE <= scanned <= SAME_SIZE * max(sizes):
        return ""
    return (
        f"scan {scan.name}: {1e3 * scanned:.3g} mm from corner to corner, the shapes "
        f"{1e3 * min(sizes):.3g} to {1e3 * max(sizes):.3g} mm: is --unit right?"
    )


SAME_SIZE = 4.0
"""Ratio of two sizes from which on a unit is in doubt; an inch is 25.4 mm."""


def _diagonal(points: Array) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


class Ranked(Protocol):
    """What is laid onto the shape of a milestone."""

    @property
    def cost(self) -> float:
        """By which milestones are ranked, m."""


def best_match(matches: Sequence[Ranked]) -> int:
    """Return the place of the milestone that fits best."""
    return min(range(len(matches)), key=lambda place: matches[place].cost)


def scan_table(matches: list[ScanMatch]) -> str:
    """Return a line a milestone, lengths in mm and in per cent of the diagonal; * fits best."""
    best = matches[best_match(matches)]
    lines = [
        "mm         rms (of the diagonal)    mean    95 %  largest  outliers  covered",
    ]
    for match in matches:
        inner = MM_PER_M * match.inner
        share = 100 * match.rms / match.diagonal
        lines.append(
            f"{match.title:8} {'*' if match is best else ' '}"
            f"{MM_PER_M * match.rms:8.3f} ({share:.2f} %)  {inner.mean():14.3f} "
            f"{np.quantile(inner, 0.95):7.3f} {inner.max():8.3f} "
            f"{100 * match.outliers.mean():7.1f} % {100 * match.coverage:6.1f} %"
        )
    return "\n".join(lines)


def ways_table(match: ScanMatch) -> str:
    """Return the distances both ways in mm and, in brackets, per cent of the shape's diagonal."""
    names = "".join(f"{name:>18}" for name in MEASURED)
    lines = [f"{match.title}, mm (% of the diagonal of {MM_PER_M * match.diagonal:.4g} mm)"]
    lines.append(f"{'':13}{names}")
    for way, distances in match.ways.items():
        values = [measure(distances) for measure in MEASURED.values()]
        texts = [f"{MM_PER_M * v:.3f} ({100 * v / match.diagonal:.2f} %)" for v in values]
        lines.append(f"{way:13}" + "".join(f"{text:>18}" for text in texts))
    return "\n".join(lines)


def scan_record(matches: list[ScanMatch]) -> dict[str, Any]:
    """Return what `scan_table` shows, in SI units; `best` is the milestone that fits best."""
    return {
        "best": matches[best_match(matches)].title,
        "units": dict.fromkeys(("rms", "mean", "quantile_95", "largest", "diagonal"), "m"),
        "milestones": [
            {
                "title": match.title,
                "rms": match.rms,
                "mean": float(match.inner.mean()),
                "quantile_95": float(np.quantile(match.inner, 0.95)),
                "largest": float(match.inner.max()),
                "diagonal": float(match.diagonal),
                "outliers": float(match.outliers.mean()),
                "covered": match.coverage,
                "back": _record_of(match.ways.get("shape to scan", np.array([np.nan]))),
            }
            for match in matches
        ],
    }


def _record_of(distances: Array) -> dict[str, float]:
    measured = [measure(distances) for measure in MEASURED.values()]
    return dict(zip(("rms", "mean", "quantile_95", "largest"), measured, strict=True))


def _laid(shape: Shape, surface: Samples, scan: Array, motion: Motion) -> ScanMatch:
    """Return the distances of a scan after a motion."""
    from scipy.spatial import cKDTree  # slow to load

    points = motion.moved(scan)
    distances = surface.nearest(points).distance
    outliers = np.abs(distances) > outlier_limit(distances)
    area = len(surface.points) * surface.spacing**2
    spacing = math.sqrt(area / max(np.count_nonzero(~outliers), 1))
    back = cKDTree(points[~outliers]).query(surface.points[::BACK])[0]
    told = distances, outliers, back, spacing, surface.diagonal
    return ScanMatch(shape.title, motion, *told, shape.milestone)


def _in_metres(surface: Surface) -> Surface:
    return Surface(np.asarray(surface.points / MM_PER_M, dtype=np.float64), surface.triangles)
