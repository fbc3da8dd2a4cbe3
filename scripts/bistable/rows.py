"""The rows of the table: the states of a case by the shell, and what the solid says of them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

import bilayer
from bilayer.landscape.report import symmetry_words
from bistable.cases import PUBLISHED, Case, trilayer

STARTS = 8
FLAT = 4e-4
"""Height below which a shape counts as flat, m: 2 % of the lotus' radius."""
DESCENT = tuple(round(1.3 - 0.01 * k, 9) for k in range(28))
"""Prestretches down which a bent state is followed until it is flat."""


@dataclass(frozen=True)
class Row:
    """A case: energies in J, lengths in m; NaN or -1 where there is no such number.

    `mirror` is the relative difference of the energies of the two mirror states. Names that begin
    with `solid` are of the finite-element model.
    """

    sheet: str
    outer: float
    prestretch: float
    triangles: int
    states: int
    pairs: int
    symmetry: str
    height: float
    energy: float
    mirror: float
    barrier: float
    saddle_modes: int
    saddle_height: float
    solid_modes: int
    solid_height: float
    solid_mirror: float

    @property
    def verdict(self) -> str:
        """Say in a word or two what the sheet has."""
        if self.pairs:
            alone = self.pairs == 1 and self.states == 2
            return "bistable" if alone else f"{self.states} states"
        return "flat alone" if self.height < FLAT else "one state"


@dataclass(frozen=True)
class Point:
    """Height of a bent state of the shell as it is followed down, m."""

    sheet: str
    outer: float
    prestretch: float
    height: float


@dataclass(frozen=True)
class Solid:
    """What the finite-element model says of the lowest state and its mirror state."""

    modes: int = -1
    height: float = math.nan
    mirror: float = math.nan


def states_of(case: Case, kept: Path) -> xr.Dataset:
    """Return the states of a case by the shell, from its file if they are there."""
    file = kept / f"{case}.nc"
    return bilayer.states(
        case.specimen, starts=STARTS, output=file, resume=file if file.exists() else None
    )


def row_of(case: Case, kept: Path) -> Row:
    """Return the row of a case."""
    found = states_of(case, kept)
    pairs = mirror_pairs(found)
    energy = found["energy"].sum("term").values
    asked = case.prestretch == PUBLISHED
    way = bilayer.barrier(found, *pairs[0]) if pairs and asked else None
    solid = solid_of(found, pairs) if asked else Solid()
    return Row(
        sheet=case.sheet,
        outer=case.specimen.layers[0].thickness,
        prestretch=case.prestretch,
        triangles=found.sizes["face"],
        states=len(energy),
        pairs=len(pairs),
        symmetry=" ".join(symmetry_words(found)),
        height=float(found["height"].values[0]),
        energy=float(energy[0]),
        mirror=_difference(energy[list(pairs[0])]) if pairs else math.nan,
        barrier=math.nan if way is None else way.attrs["barrier"],
        saddle_modes=-1 if way is None else way.attrs["saddle_modes"],
        saddle_height=math.nan if way is None else float(top_of(way)["height"].values[0]),
        solid_modes=solid.modes,
        solid_height=solid.height,
        solid_mirror=solid.mirror,
    )


def mirror_pairs(found: xr.Dataset) -> list[tuple[int, int]]:
    """Return the pairs of states that are each other turned over, the lowest first."""
    others = found["turned_over"].values
    return [(k, int(other)) for k, other in enumerate(others) if other > k]


def top_of(way: xr.Dataset) -> xr.Dataset:
    """Return the highest shape of a way, which is the saddle if one was found."""
    energy = way["energy"].sum("term").values
    return way.isel(prestretch=[1 + int(np.argmax(energy[1:-1]))])


def solid_of(found: xr.Dataset, pairs: Sequence[tuple[int, int]]) -> Solid:
    """Start the finite-element model from the lowest state and from its mirror state."""
    own = solved(found, 0)
    if own is None:
        return Solid()
    modes, height = int(own["unstable_modes"].values[0]), float(own["height"].values[0])
    other = solved(found, pairs[0][1]) if pairs else None
    if other is None:
        return Solid(modes, height)
    return Solid(modes, height, _difference(np.array([total(own), total(other)])))


def solved(found: xr.Dataset, row: int) -> xr.Dataset | None:
    """Return the equilibrium of the finite-element model near a state of the shell, or None."""
    shape = found.isel(prestretch=[row])
    specimen, mesh = bilayer.result_specimen(shape), bilayer.result_mesh(shape)
    specimen = specimen.with_milestones([specimen.prestretch.milestones[row]])
    try:
        there = bilayer.solve(specimen, "fenics", mesh=mesh, start=shape)
    except bilayer.ComputationError:
        return None
    return there if bool(there["converged"].all()) else None


def descent(case: Case, kept: Path) -> list[Point]:
    """Follow the lowest state of a case down to where it is flat."""
    found = states_of(case, kept).isel(prestretch=[0])
    sheet = trilayer(case.sheet, case.share, case.scale).with_milestones(list(DESCENT))
    path = bilayer.solve(sheet, "dshell", mesh=bilayer.result_mesh(found), start=found)
    outer = sheet.layers[0].thickness
    return [
        Point(case.sheet, outer, stretch, float(height))
        for stretch, height in zip(DESCENT, path["height"].values, strict=True)
    ]


def bent_from(points: Sequence[Point]) -> float:
    """Return the prestretch from which on a sheet is bent, NaN if it never is.

    The square of the height grows in proportion to what the prestretch is beyond it.
    """
    above = sorted((point.prestretch, point.height**2) for point in points if point.height > FLAT)
    if len(above) < 2:
        return math.nan
    (first, low), (second, high) = above[:2]
    return first - low * (second - first) / (high - low)


def total(result: xr.Dataset) -> float:
    """Return the energy of a result of one milestone, J."""
    return float(result["energy"].sum("term").values[0])


def _difference(energies: np.ndarray) -> float:
    """Return how far two energies are apart, relative to the lower one."""
    return float(np.ptp(energies) / energies.min())
