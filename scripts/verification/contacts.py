"""Shells that touch: themselves, each other, rigid planes. SI units.

The fold between two planes is an elastica: a strip of bending stiffness B per width that leaves
either plane where its curvature is 0. With the angle a from the plane and the force F per width,
B a'^2 / 2 = F sin a. Over the height h between the planes, twice the integral of sin a ds, that is
F = 2 B I^2 / h^2 with I the integral of sqrt(sin a) from 0 to 90 degrees, 1.19814. It is the
two-point bend of Matthewson, Kurkjian and Gulati (J. Am. Ceram. Soc. 69, 1986).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer import PlanarMesh
from bilayer.contact.barrier import Barrier
from bilayer.contact.obstacles import Obstacle, ObstacleBarrier, Plane
from bilayer.contact.several import SeveralBarriers
from bilayer.contact.skin import BondedBody, Sheet
from bilayer.contact.skin_map import SkinMap
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import flat_surface
from dshell.energies.assembly import coordinates_of, deform, gradient_of
from dshell.energies.skin_contact import SkinContact
from verification.meshes import rectangle
from verification.shell_problem import Problem, nodes_of, plate, pressure, single_layer

Array = NDArray[np.float64]

SQUARE_ROOT_OF_SINE = 1.1981402347355923
"""Its integral from 0 to 90 degrees."""
FOLD_FORCE = 2 * SQUARE_ROOT_OF_SINE**2
"""F h^2 / B."""
YOUNG, STIFFNESS = 1e6, 3e4
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


@dataclass(frozen=True)
class Pieces:
    """A flat mesh of more than one piece, which a `PlanarMesh` is not."""

    points: Array
    triangles: NDArray[np.int64]

    @property
    def areas(self) -> Array:
        """Of the triangles, m2."""
        return flat_surface(self).areas


def skin_of_plate(mesh: PlanarMesh, thickness: float) -> SkinMap:
    """Skin of one layer about its mid-plane."""
    faces = np.arange(len(mesh.triangles))
    return SkinMap.of(BondedBody(mesh, [Sheet(-thickness / 2, thickness / 2, faces)]))


def obstacle_barrier(
    mesh: PlanarMesh, skin: SkinMap, obstacles: list[Obstacle], reach: float
) -> ObstacleBarrier:
    """Barrier of a skin to obstacles."""
    flat = Surface(skin.points(flat_surface(mesh).points), skin.triangles)
    return ObstacleBarrier(obstacles, flat.node_areas, range=reach, stiffness=STIFFNESS)


@dataclass(frozen=True)
class Fold:
    """A strip folded between two planes.

    Parameters
    ----------
    force : float
        With which either plane presses, times h^2 / B and over the width: 2 I^2 = 2.871.
    balance : float
        Difference of the forces of the planes over their mean.
    gap : float
        Smallest distance from a plane over the range.
    """

    force: float
    balance: float
    gap: float


def fold_between_planes(cells: int, reach: float = 0.05) -> Fold:
    """A strip of 60 mm folded between two planes, 12 mm apart; the range over the thickness.

    Across it there are a fifteenth of the cells along it: at its free edges the shell is softer.
    """
    length, width, thickness, apart = 0.06, 0.004, 2e-4, 0.012
    step = length / cells
    mesh = rectangle(
        np.linspace(0, length, cells + 1), np.linspace(-width / 2, width / 2, cells // 15 + 1)
    )
    faces, flat = plate(mesh, [single_layer(YOUNG, 0.0, thickness)])
    skin = skin_of_plate(mesh, thickness)
    planes = [Plane((0, 0, -apart / 2), UP), Plane((0, 0, apart / 2), DOWN)]
    barrier = obstacle_barrier(mesh, skin, list(planes), reach * thickness)
    start = flat.copy()
    start[: 3 * len(mesh.points)] = _folded(mesh.points, length, apart - 2 * thickness).reshape(-1)
    apex = np.argmin(np.abs(mesh.points[:, 0] - length / 2) + np.abs(mesh.points[:, 1]))
    held = np.concatenate([3 * np.arange(len(mesh.points)) + 1, [3 * apex]])
    contact = SkinContact(skin, barrier, len(mesh.points))
    problem = Problem(faces, flat, held, np.zeros(len(flat)), contact=contact)
    bending = YOUNG * thickness**3 / 12
    problem.least_force = (
        bending * width / apart**2
    )  # there is no load that it could be relative to
    state = problem.solved(1e-9, step, start, iterations=200)
    touching = contact.at(state).barrier
    sides = touching.gradient[:, 2]
    below, above = -sides[sides < 0].sum(), sides[sides > 0].sum()
    height = np.ptp(nodes_of(state, mesh)[:, 2])
    force = (below + above) / 2
    return Fold(
        force * height**2 / bending / width,
        abs(below - above) / force,
        touching.smallest_gap / barrier.range,
    )


@dataclass(frozen=True)
class Lifted:
    """A heavy strip on a plane, one end lifted.

    Parameters
    ----------
    pull : float
        Force at the lifted end over w l / 2, the lifted length l being (24 B d / w)^(1/4).
    balance : float
        Weight less the forces of plane and end, over the weight.
    gap : float
        Smallest distance from the plane over the range.
    """

    pull: float
    balance: float
    gap: float


def lifted_strip(cells: int) -> Lifted:
    """A strip of 100 mm lies on a plane; its end is lifted by a tenth of the lifted length.

    Where it leaves the plane its curvature is 0, at its end, too. With the weight w per length
    beam theory gives d = w l^4 / 24 B and a pull of w l / 2.
    """
    length, width, thickness, lifted = 0.1, 0.004, 2e-4, 0.05
    mesh = rectangle(
        np.linspace(0, length, cells + 1), np.linspace(-width / 2, width / 2, cells // 15 + 1)
    )
    faces, flat = plate(mesh, [single_layer(YOUNG, 0.0, thickness)])
    bending, rise = YOUNG * thickness**3 / 12, 0.02 * lifted
    weight = 24 * bending * rise / lifted**4
    reach, count = 0.2 * thickness, len(mesh.points)
    skin = skin_of_plate(mesh, thickness)
    barrier = obstacle_barrier(mesh, skin, [Plane((0, 0, 0), UP)], reach)
    contact = SkinContact(skin, barrier, count)
    lying = _resting_height(barrier, weight) + thickness / 2
    x = mesh.points[:, 0]
    start = flat.copy()
    start[2 : 3 * count : 3] = lying + rise * np.maximum(0, 1 - (length - x) / lifted)
    end = np.flatnonzero(x > length * (1 - 1e-9))
    held = np.concatenate([3 * np.arange(count) + 1, 3 * np.flatnonzero(x < 1e-12), 3 * end + 2])
    load = pressure(mesh, len(flat), -weight)
    problem = Problem(faces, start, held, load, contact=contact)
    state = problem.solved(1e-9, length, iterations=200)
    pushed = -contact.at(state).barrier.gradient[:, 2].sum()
    pull = _reactions(problem, state)[3 * end + 2].sum()
    whole = -load.sum()
    return Lifted(
        pull / (weight * width * lifted / 2),
        abs(whole - pushed - pull) / whole,
        contact.at(state).barrier.smallest_gap / reach,
    )


def _resting_height(barrier: ObstacleBarrier, weight: float) -> float:
    """Height over the plane at which a weight per area rests."""
    shares = np.linspace(1e-3, 1, 100001)[:-1]
    press = 2 * (shares - 1) * np.log(shares) + (shares - 1) ** 2 / shares
    return float(barrier.range * np.interp(-weight / barrier.stiffness, -press, shares))


def _reactions(problem: Problem, state: Array) -> Array:
    """Forces of what is held, N, in the shape of a state."""
    forces = gradient_of(deform(problem.energies, state)) - problem.load
    return forces + problem.contact.at(state).gradient


@dataclass(frozen=True)
class Stack:
    """Two plates on a plane, pressed down.

    Parameters
    ----------
    between, below : float
        Force between the plates, and on the plane, over the load.
    gap : float
        Smallest distance over the range.
    crosses : bool
        Whether the plates pass through each other.
    """

    between: float
    below: float
    gap: float
    crosses: bool


def pressed_plates(cells: int) -> Stack:
    """A plate of 10 mm on a plane, a smaller one on top, under a pressure of 100 Pa.

    Flat they lie side by side. Each is held in its own plane alone.
    """
    thickness, load_per_area, reach = 5e-4, 100.0, 1e-4
    lower = rectangle(*2 * [np.linspace(-5e-3, 5e-3, cells + 1)], jitter=0.2)
    upper = rectangle(*2 * [np.linspace(-3.3e-3, 3.3e-3, cells)], jitter=0.2)
    aside = np.array([20e-3, 0.0])
    count = len(lower.points)
    mesh = Pieces(
        np.concatenate([lower.points, upper.points + aside]),
        np.concatenate([lower.triangles, upper.triangles + count]),
    )
    faces, flat = plate(mesh, [single_layer(YOUNG, 0.3, thickness)])
    skin = skin_of_plate(mesh, thickness)
    itself = Barrier.of(skin, flat_surface(mesh).points, range=reach, stiffness=STIFFNESS)
    floor = obstacle_barrier(mesh, skin, [Plane((0, 0, 0), UP)], itself.range)
    contact = SkinContact(skin, SeveralBarriers([itself, floor]), len(mesh.points))
    start = flat.copy()
    nodes = start[: 3 * len(mesh.points)].reshape(-1, 3)
    nodes[:, 2] = thickness / 2 + 0.9 * itself.range
    nodes[count:] += [-aside[0] + 4e-4, 3e-4, thickness + 0.9 * itself.range]
    load = pressure(mesh, len(flat), -load_per_area)
    load[: 3 * count] = 0.0
    held = np.concatenate([_held_in_plane(lower), 3 * count + _held_in_plane(upper)])
    problem = Problem(faces, start, held, load, contact=contact)
    state = problem.solved(1e-10, 1e-3, iterations=200)
    found = contact.at(state).barrier
    between, below = (part.gradient[:, 2] for part in found.parts)
    whole = -load.sum()
    return Stack(
        np.maximum(between, 0).sum() / whole,
        -below.sum() / whole,
        found.smallest_gap / itself.range,
        contact.is_crossed(state),
    )


def _held_in_plane(mesh: PlanarMesh) -> NDArray[np.int64]:
    """Three coordinates that hold a plate in its own plane."""
    far = np.argmax(mesh.points[:, 0])
    near = np.argmin(mesh.points[:, 0])
    return np.concatenate([coordinates_of(near)[:2], coordinates_of(far)[1:2]])


def _folded(points: Array, length: float, height: float) -> Array:
    """A U: a half circle with straight arms, by the length along it."""
    along, radius = points[:, 0] - length / 2, height / 2
    half = np.pi / 2 * radius
    turn = np.clip(along, -half, half) / radius
    beyond = along - turn * radius
    x = radius * np.cos(turn) - np.abs(beyond)
    return np.column_stack([x, points[:, 1], radius * np.sin(turn)])
