"""The thin cross on a square: where it loses its symmetry, and the shell on finer and finer meshes.

Only the shell is computed. The four corners of the square lie alike over the plane of the arms'
ends until the sheet loses that symmetry; then two opposite ones rise, the other two sink. Like at
any loss of symmetry, the square of that amplitude grows with the distance from the prestretch where
it begins, so just beyond it a small change of that prestretch moves the shape far.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.optimize import brentq

import bilayer
from sheet_comparison.cases import MILESTONES, Case

SHEET = Case("cross on a square", "bilayer", 0.02)
SIZES = (1.4e-3, 1e-3, 0.75e-3, 0.5e-3)
"""Of the mesh, m."""
PATH = (1.02, 1.025, 1.0275, 1.0325, 1.035, 1.04)
"""Further milestones on the coarsest mesh, through the loss of symmetry."""
BEGUN = 0.05
"""Amplitude over the characteristic length that is no round-off and no doing of the mesh."""
HALF = 0.02
"""Of the square's side, m."""


@dataclass(frozen=True)
class CrossRow:
    """The shell at one milestone; lengths over the characteristic length, `mesh_size` in m."""

    mesh_size: float
    triangles: int
    prestretch: float
    height: float
    corners: float
    energy: float


def cross_rows(kept: Path) -> Iterator[CrossRow]:
    """Compute the shell along the path and on all meshes.

    Parameters
    ----------
    kept : Path
        Folder of the results; those that are there are not computed again.
    """
    runs = [(SIZES[0], PATH), *((size, MILESTONES) for size in SIZES)]
    for size, milestones in runs:
        specimen = replace(SHEET.specimen, mesh=bilayer.MeshSize(size)).with_milestones(milestones)
        path = kept / f"cross_{1e3 * size:g}_mm_{len(milestones)}_milestones.nc"
        result = bilayer.solve(
            specimen, "dshell", output=path, resume=path if path.exists() else None
        )
        length = specimen.characteristic_length
        for k, stretch in enumerate(milestones):
            yield CrossRow(
                size,
                result.sizes["face"],
                stretch,
                float(result["height"][k]) / length,
                corner_amplitude(result.isel(prestretch=k)) / length,
                float(result["energy"][k].sum("term", skipna=False)),
            )


def corner_amplitude(shape: xr.Dataset) -> float:
    """Return a quarter of how far two opposite corners lie over the other two, m, positive.

    Heights are those over the plane through the ends of the arms.
    """
    flat, position = shape["reference_position"].values[:, :2], shape["position"].values
    ends, corners = (
        position[
            [int(np.argmin(((flat - HALF * np.array(place)) ** 2).sum(axis=1))) for place in places]
        ]
        for places in (((1, 0), (0, 1), (-1, 0), (0, -1)), ((1, 1), (-1, 1), (-1, -1), (1, -1)))
    )
    normal = np.cross(ends[0] - ends[2], ends[1] - ends[3])
    heights = (corners - ends.mean(axis=0)) @ normal / np.linalg.norm(normal)
    return abs(float(heights @ (1, -1, 1, -1))) / 4


def along_path(rows: Sequence[CrossRow]) -> list[CrossRow]:
    """Return the rows of the coarsest mesh through the loss of symmetry, by prestretch."""
    path = [row for row in rows if row.mesh_size == SIZES[0] and row.prestretch <= max(PATH)]
    return sorted(path, key=lambda row: row.prestretch)


def loses_symmetry_at(rows: Sequence[CrossRow]) -> float:
    """Return the prestretch at which the amplitude begins, by its square in two rows beyond."""
    first, second = [row for row in along_path(rows) if row.corners > BEGUN][:2]
    slope = (second.corners**2 - first.corners**2) / (second.prestretch - first.prestretch)
    return first.prestretch - first.corners**2 / slope


def height_without_mesh(rows: Sequence[CrossRow], stretch: float) -> tuple[float, float]:
    """Return the height on an ever finer mesh, and how fast heights come to it, of three meshes.

    The order p is that of height = limit + c size^p through the three finest.
    """
    found = {row.mesh_size: row.height for row in rows if row.prestretch == stretch}
    coarse, middle, fine = sorted(found, reverse=True)[-3:]
    measured = (found[middle] - found[coarse]) / (found[fine] - found[middle])

    def error(order: float) -> float:
        return (middle**order - coarse**order) / (fine**order - middle**order) - measured

    order = float(brentq(error, 0.1, 8.0))
    slope = (found[fine] - found[middle]) / (fine**order - middle**order)
    return found[fine] - slope * fine**order, order
