"""Strips with walls: a bar of kirigami on a wide substrate, and a strip in torsion.

A bar of kirigami lies along a wide substrate, its length held.

The substrate is stretched across the bar. Released, the strip beside the bar shrinks and stays
straight, and the bar bends it. By laminate theory the two sides of the strip then lie at an angle
of the bar's natural curvature times its width. They lie at less, as the kirigami bears nothing at
its walls. What is missing, told as a width that each wall takes from the bar, over the kirigami's
thickness, tends to a constant for wide bars. The mismatch is small. SI units.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from bilayer import Layer, MooneyRivlin, PlanarMesh, Prestretch, Rectangle, Response, Specimen
from dshell.energies.through_thickness import Laminate
from dshell.models.morley import WALL_WIDTH, specimen_layers
from dshell.models.wall_faces import walls_of
from dshell.models.wall_relief import wall_zones
from verification.meshes import rectangle
from verification.rung import Check

Array = NDArray[np.float64]

SUBSTRATE = Layer(
    "substrate", 1.1e-3, MooneyRivlin(22060.0, 1656.0, 1e-5), response=Response("path")
)
KIRIGAMI = Layer("kirigami", 1.6e-3, MooneyRivlin(17880.0, 84450.0, 1e-5))
"""Of the bistable sheets that `scripts/any_sheet` computes."""
STRETCH = 1.0001
BESIDE = 8e-3
"""Width of bare substrate on either side, m."""
LENGTH = 0.5e-3
"""Of the piece of the strip, m."""


def missing(angle: float, width: float) -> float:
    """What each wall takes from a bar, over the kirigami's thickness, by the sides' angle."""
    full = shell_angle(width, 4, relieves=False)
    return (1 - angle / full) * width / 2 / KIRIGAMI.thickness


def shell_angle(width: float, cells: int, relieves: bool = True) -> float:
    """The sides' angle by the shell's layers, on so many cells across the bar.

    Each cell bends on its own, as the strip bears no force and no moment.
    """
    across = np.linspace(-width / 2, width / 2, cells + 1)
    size = width / cells
    beside = width / 2 + size * np.arange(1, round(BESIDE / size) + 2)
    mesh = strip(np.concatenate([-beside[::-1], across, beside]), width)
    laminate, strains = _laminate(mesh, relieves), np.zeros((6, len(mesh.triangles)))
    for _ in range(4):
        bent = laminate.at(strains)
        stiff = np.moveaxis(bent.stiffness()[np.ix_([0, 3], [0, 3])], 2, 0)
        forces = bent.resultants()[[0, 3]].T[:, :, None]
        strains[[0, 3]] -= np.linalg.solve(stiff, forces)[:, :, 0].T
    return float(mesh.areas @ strains[3] / LENGTH)


def strip(x: Array, width: float) -> PlanarMesh:
    """A piece of the strip, one cell long, the bar in its middle."""
    mesh = rectangle(x, np.array([0.0, LENGTH]))
    middle = mesh.points[mesh.triangles, 0].mean(axis=1)
    return PlanarMesh(mesh.points, mesh.triangles, np.where(np.abs(middle) < width / 2, 1, 0))


def _laminate(mesh: PlanarMesh, relieves: bool) -> Laminate:
    specimen = Specimen(Rectangle(0.1, 0.01), [SUBSTRATE, KIRIGAMI], Prestretch((STRETCH,)))
    layers = specimen_layers(specimen, mesh, (STRETCH, 1.0))
    if not relieves:
        return Laminate(layers, 1.0)
    width = WALL_WIDTH * (SUBSTRATE.thickness + KIRIGAMI.thickness)
    walls = walls_of(mesh, width, mesh.boundary_edges)
    return Laminate(layers, 1.0, wall_zones(layers, walls, len(mesh.triangles)))


def torsion(width: float) -> float:
    """The stiffness of a strip against twist over G w t^3 / 3, its width over its thickness given.

    By relieved layers; without relief it is 1.
    """
    thickness = 1e-3
    layer = Layer("substrate", thickness, MooneyRivlin(22060.0, 1656.0, 1e-5))
    specimen = Specimen(Rectangle(0.1, 0.1), [layer], Prestretch((1.0,)))
    across = width * thickness * np.linspace(-0.5, 0.5, 5)
    mesh = rectangle(across, np.array([0.0, LENGTH]))
    mesh = PlanarMesh(mesh.points, mesh.triangles, 0 * mesh.region, (frozenset({"substrate"}),))
    ends = mesh.boundary_edges
    ends = ends[np.ptp(mesh.points[ends, 1], axis=1) == 0]
    layers = specimen_layers(specimen, mesh, (1.0, 1.0))
    walls = walls_of(mesh, WALL_WIDTH * thickness, ends)
    zones = wall_zones(layers, walls, len(mesh.triangles))
    stiff = Laminate(layers, 1.0, zones).at(np.zeros((6, len(mesh.triangles)))).stiffness()[5, 5]
    full = layer.material.shear_modulus * thickness**3 / 12
    return float(mesh.areas @ stiff / mesh.areas.sum() / full)


def st_venant(width: float) -> float:
    """The same of a rectangle by St. Venant's series (Timoshenko and Goodier, Theory of
    Elasticity, section 109)."""
    n = np.arange(1, 400, 2)
    return float(1 - 192 / np.pi**5 / width * (np.tanh(n * np.pi * width / 2) / n**5).sum())


def torsion_checks() -> Iterator[Check]:
    """Strips of several widths in torsion; the error is over that of a wide one."""
    for width in (0.5, 1.0, 2.0, 5.0, 20.0):
        found, exact = torsion(width), st_venant(width)
        yield Check(f"torsion of a strip, w / t = {width:g}", found, exact, 0.03, 1.0)


def mesh_checks() -> Iterator[Check]:
    """One bar on several meshes, and bars of several widths, against the first."""
    widths, cells = (4.8e-3, 9.6e-3, 19.2e-3), (2, 7, 32)
    first = missing(shell_angle(widths[0], cells[0]), widths[0])
    for width in widths:
        for count in cells:
            case = f"bar of {width / KIRIGAMI.thickness:g} t, {count} cells: width taken / t"
            yield Check(case, missing(shell_angle(width, count), width), first, 0.005)
