"""A profile from a photograph: the upper edge of the part as seen from the side.

The camera looks level and from far, so that the edge is the envelope of the shape in a vertical
plane. The plane's direction is not known: all directions are tried, and the profile is shifted in
its plane by iterated closest points. It is not turned: up is up.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.geometry.surface import Surface
from bilayer.results.milestones import along_milestones
from bilayer.results.released_shapes import MM_PER_M, released_shapes
from bilayer.results.schema import result_mesh
from bilayer.scan.cloud import read_table
from bilayer.scan.comparison import best_match
from bilayer.scan.samples import Samples, even_samples
from bilayer.validation import positive

Array = NDArray[np.float64]

DIRECTIONS = 72
"""Tried, over a full turn: from the other side the profile is the mirror image."""
SAMPLES, BINS = 20_000, 120
"""Points of a shape, and pieces of its width in which the highest of them counts."""
DENSE = 20
"""Points that stand for a piece of the edge."""
ROUGH, LIKELY = 5, 8
"""Steps of the shift from every direction, and from how many of them it goes on."""
LONGEST, STILL = 40, 1e-7
"""Steps of the shift at most; the last is shorter than so many m."""
LEAST_POINTS = 5


@dataclass(frozen=True)
class Profile:
    """Points on the upper edge of a part.

    Parameters
    ----------
    name : str
        Of the file.
    points : ndarray, shape (n, 2)
        To the right and up, m.
    """

    name: str
    points: Array

    def __post_init__(self) -> None:
        shape = self.points.shape
        if len(shape) != 2 or shape[1] != 2 or shape[0] < LEAST_POINTS:
            raise InputError(
                f"profile {self.name}: has shape {shape}, expected at least {LEAST_POINTS} points "
                "(n, 2)"
            )
        if not np.isfinite(self.points).all():
            raise InputError(f"profile {self.name}: expected finite coordinates")


@dataclass(frozen=True)
class ProfileMatch:
    """A profile laid onto the edge of one milestone.

    Parameters
    ----------
    title : str
        The milestone.
    azimuth : float
        Direction in which the profile runs to the right, from x of the body frame, rad.
    shift : ndarray, shape (2,)
        What lays it there, m.
    distances : ndarray, shape (n,)
        Of its points from the edge, m.
    edge : ndarray, shape (k, 2)
        Points of the shape's edge from there, m.
    diagonal : float
        Of the box around the shape, m.
    """

    title: str
    azimuth: float
    shift: Array
    distances: Array
    edge: Array
    diagonal: float

    @property
    def rms(self) -> float:
        """Root mean square of the distances, m."""
        return float(np.sqrt(np.mean(self.distances**2)))

    @property
    def cost(self) -> float:
        """By which milestones are ranked, m."""
        return self.rms


def read_profile(path: str | Path, unit: float = 1e-3) -> Profile:
    """Read a profile: a table of two columns, to the right and up, with or without names.

    Parameters
    ----------
    path : path-like
        CSV or columns separated by spaces.
    unit : float
        One unit of its coordinates, m.

    Raises
    ------
    InputError
        It cannot be read, or is no table of two columns.
    """
    source = Path(path)
    return Profile(source.name, positive("unit", unit, "m") * read_table(source, columns=2))


def compare_profile(result: xr.Dataset, profile: Profile) -> list[ProfileMatch]:
    """Lay a profile onto the upper edge of each milestone.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.
    profile : Profile
        Of the part.

    Returns
    -------
    list of ProfileMatch
        One for each milestone that has a shape; that of the least `rms` fits best.

    Raises
    ------
    InputError
        The result holds no shape.
    """
    reached = along_milestones(result)
    shapes = released_shapes(reached, result_mesh(reached))
    return [_best(shape.title, shape.surface, profile.points) for shape in shapes]


def profile_table(matches: list[ProfileMatch]) -> str:
    """Return a line a milestone, in mm and in per cent of the diagonal; * fits best."""
    best = best_match(matches)
    lines = ["mm         rms (of the diagonal)    95 %  largest  azimuth"]
    lines += [
        f"{match.title:8} {'*' if place == best else ' '}"
        f"{MM_PER_M * match.rms:8.3f} ({100 * match.rms / match.diagonal:.2f} %)  "
        f"{MM_PER_M * np.quantile(match.distances, 0.95):14.3f} "
        f"{MM_PER_M * match.distances.max():8.3f} {np.degrees(match.azimuth):6.0f} deg"
        for place, match in enumerate(matches)
    ]
    return "\n".join(lines)


def profile_record(matches: list[ProfileMatch]) -> dict[str, Any]:
    """Return what `profile_table` shows, in SI units; `best` is the milestone that fits best."""
    return {
        "best": matches[best_match(matches)].title,
        "units": dict.fromkeys(("rms", "quantile_95", "largest", "diagonal"), "m")
        | {"azimuth": "rad"},
        "milestones": [
            {
                "title": match.title,
                "rms": match.rms,
                "quantile_95": float(np.quantile(match.distances, 0.95)),
                "largest": float(match.distances.max()),
                "diagonal": match.diagonal,
                "azimuth": match.azimuth,
            }
            for match in matches
        ],
    }


def _best(title: str, surface: Surface, profile: Array) -> ProfileMatch:
    """Return the profile laid onto the edge from the direction that suits it best."""
    metres = Surface(np.asarray(surface.points / MM_PER_M, dtype=np.float64), surface.triangles)
    samples = even_samples(metres, SAMPLES)
    turns = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    rough = [_laid(title, float(turn), samples, profile, ROUGH) for turn in turns]
    likely = sorted(rough, key=lambda match: match.cost)[:LIKELY]
    matches = [_laid(title, match.azimuth, samples, profile, LONGEST) for match in likely]
    return matches[best_match(matches)]


def edge_of(points: Array, azimuth: float) -> Array:
    """Return the upper edge of points as seen from the side, (k, 2), m.

    Parameters
    ----------
    points : (n, 3) array of float
        Many points of a shape, m.
    azimuth : float
        Direction that the edge runs along, from x, rad.
    """
    along = points[:, 0] * np.cos(azimuth) + points[:, 1] * np.sin(azimuth)
    low, width = along.min(), np.ptp(along) / BINS
    place = np.minimum(((along - low) / width).astype(np.int64), BINS - 1)
    order = np.lexsort((points[:, 2], place))
    last = np.flatnonzero(np.diff(place[order], append=BINS))
    highest = order[last]
    return np.column_stack([along[highest], points[highest, 2]])


def _laid(title: str, azimuth: float, shape: Samples, profile: Array, steps: int) -> ProfileMatch:
    """Return a profile shifted onto the edge from a direction, a line through its points."""
    from scipy.spatial import cKDTree  # slow to load

    edge = edge_of(shape.points, azimuth)
    share = np.arange(DENSE)[:, None, None] / DENSE
    line = ((1 - share) * edge[:-1] + share * edge[1:]).reshape(-1, 2)
    tree = cKDTree(line)
    shift = np.array([edge[:, 0].mean(), edge[:, 1].max()])
    shift -= [profile[:, 0].mean(), profile[:, 1].max()]
    for _ in range(steps):
        nearest = tree.query(profile + shift)[1]
        step = np.mean(line[nearest] - profile - shift, axis=0)
        shift = shift + step
        if np.linalg.norm(step) < STILL:
            break
    distances = tree.query(profile + shift)[0]
    return ProfileMatch(title, azimuth, shift, np.asarray(distances), edge, shape.diagonal)
