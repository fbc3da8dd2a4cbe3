"""How far layers give way at the wall where they end: the section across it, by finite elements.

A shell takes its strain to be linear through the thickness up to the wall of a cut. The wall bears
no load, so within about a thickness of it the layers that end there are relieved of their stress.
By the theory of plates, the edge zone lowers the energy per length of the wall by

    d.C d / 2,     d = (N, M of each layer that ends),

N and M the force and the moment, about the layer's middle, that the shell has at the wall. C is
found here for the stress across the wall (plane strain, d = N_nn, M_nn), and for that along it
(antiplane shear, d = N_nt, M_nt). The latter of a plate alone is what makes the torsional stiffness
of a strip of width w and thickness t G w t^3 / 3 (1 - 0.63 t / w) (St. Venant). Strains are small,
the layers isotropic.

The shell's own solution, on both sides of the wall, is taken away from the section. What is left is
loaded at the wall alone, and decays within a few thicknesses: by the tractions that the layers have
too much there, and by how much they stretch in thickness (plane strain), which differs on the two
sides and has to be made to fit.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

FIRST_CELL, GROWTH = 0.05, 2.0
"""Cells at a corner of the wall over the thickness of their layer, and how they grow from there.

C is then within 1 % of its limit on finer and finer ones (`tests/dshell/test_wall_section.py`)."""
REACH = 8.0
"""Length of the section to either side, over the thickness of all layers."""
SOFTEST_THICKNESS = 0.4999
"""Largest Poisson's ratio of the section; up to 1/2 the energy changes by less than 0.1 %."""

_AT = np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0])
_WEIGHT = np.array([5.0, 8.0, 5.0]) / 9


@dataclass(frozen=True)
class Ply:
    """A layer beside a wall.

    Parameters
    ----------
    bottom, top : float
        Heights, m.
    young_modulus, poisson_ratio : float
        For small strain, Pa and 1.
    ends : bool
        Whether it ends at the wall, or goes on.
    """

    bottom: float
    top: float
    young_modulus: float
    poisson_ratio: float
    ends: bool

    @property
    def thickness(self) -> float:
        """Thickness, m."""
        return self.top - self.bottom

    @property
    def middle(self) -> float:
        """Height of its middle, m."""
        return (self.bottom + self.top) / 2

    @property
    def shear_modulus(self) -> float:
        """Shear modulus, Pa."""
        return self.young_modulus / (2 + 2 * self.poisson_ratio)

    @property
    def plane_strain_modulus(self) -> float:
        """Stress over strain if one direction of the plane is held, Pa."""
        return self.young_modulus / (1 - self.poisson_ratio**2)


@dataclass(frozen=True, eq=False)
class WallCompliance:
    """C of a wall, in the order N, M of each layer that ends, from the bottom up.

    Parameters
    ----------
    across, along : (2 m, 2 m) array of float
        For the stress across the wall and for that along it.
    """

    across: Array
    along: Array


@lru_cache(maxsize=256)
def wall_compliance(
    plies: Sequence[Ply], first_cell: float = FIRST_CELL, growth: float = GROWTH
) -> WallCompliance:
    """Return the compliance of a wall.

    Parameters
    ----------
    plies : tuple of Ply
        From the bottom up, each on the one before; those that go on as well.
    first_cell, growth : float
        Of the mesh of the section, see `FIRST_CELL`.
    """
    cells = _Cells.of(plies, first_cell, growth)
    return WallCompliance(_compliance(_PlaneStrain(cells)), _compliance(_Antiplane(cells)))


@dataclass(frozen=True, eq=False)
class _Cells:
    """Rectangles of nine nodes; x across the wall from 0, where it stands, into the layers."""

    plies: Sequence[Ply]
    ply: Numbers  # of each cell
    start: Array  # lower left corner, (2, m)
    size: Array  # (2, m)
    node: Numbers  # (m, 9), by x, then by z
    points: Array  # (2, n)

    @classmethod
    def of(cls, plies: Sequence[Ply], first_cell: float, growth: float) -> "_Cells":
        height = plies[-1].top - plies[0].bottom
        finest = first_cell * min(ply.thickness for ply in plies)
        away = _graded(REACH * height, finest, growth)
        goes_on = not all(ply.ends for ply in plies)
        x = np.concatenate([-away[:0:-1], away]) if goes_on else away
        levels = [_both_ways(ply, first_cell, growth) for ply in plies]
        z = np.concatenate([levels[0][:1], *(level[1:] for level in levels)])
        ply = np.repeat(np.arange(len(plies)), [len(level) - 1 for level in levels])
        column, row = (axis.reshape(-1) for axis in np.indices((len(x) - 1, len(z) - 1)))
        ends = np.array([each.ends for each in plies])
        solid = (x[column] >= 0) | ~ends[ply[row]]
        column, row = column[solid], row[solid]
        across, up = np.indices((3, 3)).reshape(2, 9)
        number = (2 * column[:, None] + across) * (2 * len(z) - 1) + 2 * row[:, None] + up
        used, node = np.unique(number, return_inverse=True)
        places = np.divmod(used, 2 * len(z) - 1)
        points = [_at_halves(axis)[place] for axis, place in zip((x, z), places, strict=True)]
        size = np.stack([np.diff(x)[column], np.diff(z)[row]])
        start = np.stack([x[column], z[row]])
        return cls(plies, ply[row], start, size, node.reshape(-1, 9), np.stack(points))

    @property
    def is_before(self) -> NDArray[np.bool_]:
        """Which cells lie on the side where the layers have ended."""
        return self.start[0] < 0

    @property
    def at_wall(self) -> NDArray[np.bool_]:
        """Which cells of the other side have a face in the plane of the wall."""
        return self.start[0] == 0

    def of_ply(self, values: Sequence[float]) -> Array:
        """Return one value of each layer for each cell."""
        return np.array(values)[self.ply]


class _PlaneStrain:
    """The displacements x, z of all nodes, one after the other; volume as in Q2/P1."""

    def __init__(self, cells: _Cells) -> None:
        self.cells, count = cells, cells.points.shape[1]
        self.dofs = np.concatenate([cells.node, cells.node + count], axis=1)
        self.moduli = [ply.plane_strain_modulus for ply in cells.plies]
        self.modes = 2  # strain and curvature
        far = np.flatnonzero(cells.points[0] == cells.points[0].max())[[0, -1]]
        self.held = np.array([far[0], far[1], count + far[0]])

    def matrices(self) -> Array:
        """Return the stiffness of each cell, (m, 18, 18)."""
        cells = self.cells
        shear = cells.of_ply([ply.shear_modulus for ply in cells.plies])
        ratio = cells.of_ply([min(ply.poisson_ratio, SOFTEST_THICKNESS) for ply in cells.plies])
        bulk = 2 * shear * ratio / (1 - 2 * ratio)
        (by_x, by_z), weights = _gradients(cells)
        none = np.zeros_like(by_x)
        exx, ezz = (np.concatenate(pair, axis=1) for pair in ((by_x, none), (none, by_z)))
        gxz = np.concatenate([by_z, by_x], axis=1)
        parts = [_product(2 * shear[:, None] * weights, e) for e in (exx, ezz)]
        parts.append(_product(shear[:, None] * weights, gxz))
        xi, eta = (axis.reshape(-1) for axis in np.meshgrid(_AT, _AT, indexing="ij"))
        linear = np.stack([np.ones(9), np.sqrt(3) * xi, np.sqrt(3) * eta])
        share = weights / weights.sum(axis=1, keepdims=True)
        volume = np.einsum("kq,mq,maq->mak", linear, share, exx + ezz)
        parts.append(_product(np.outer(bulk * weights.sum(axis=1), np.ones(3)), volume))
        return np.asarray(sum(parts))

    def lifted(self, strain: Array) -> Array:
        """Return the displacements at the wall that the shell has there, (dofs, k).

        They are how far the layers that go on have moved by the change of their thickness, for
        strain and curvature (2, k) in which they differ from those on the other side.
        """
        x, z = self.cells.points
        moved = np.zeros((2 * len(x), strain.shape[1]))
        for ply in self.cells.plies:
            if not ply.ends:
                place = np.clip(z, ply.bottom, ply.top)[:, None]
                ratio = ply.poisson_ratio / (1 - ply.poisson_ratio)
                moved[len(x) :] -= ratio * strain[0] * (place - ply.bottom)
                moved[len(x) :] -= ratio * strain[1] * (place**2 - ply.bottom**2) / 2
        moved[len(x) :] *= (x == 0)[:, None]
        return moved


class _Antiplane:
    """The displacement along the wall of all nodes; the twist is the same on both sides of it."""

    def __init__(self, cells: _Cells) -> None:
        self.cells, self.dofs = cells, cells.node
        self.moduli = [ply.shear_modulus for ply in cells.plies]
        self.modes = 1  # shear
        self.held = np.flatnonzero(cells.points[0] == cells.points[0].max())[:1]

    def matrices(self) -> Array:
        """Return the stiffness of each cell, (m, 9, 9)."""
        slopes, weights = _gradients(self.cells)
        stiff = self.cells.of_ply(self.moduli)[:, None] * weights
        return np.asarray(sum(_product(stiff, slope) for slope in slopes))

    def lifted(self, strain: Array) -> Array:
        """Return zero: the layers that go on fit together."""
        return np.zeros((self.cells.points.shape[1], strain.shape[1]))


def _compliance(section: "_PlaneStrain | _Antiplane") -> Array:
    """Return C of a section."""
    cells = section.cells
    matrices = section.matrices()
    shell, tractions = _shell_at_wall(section)
    moved = section.lifted(shell)
    size, before = len(moved), cells.is_before
    own = _assembled(matrices[before], section.dofs[before], size) @ moved
    force = _wall_forces(section, tractions, size) - own
    free = np.setdiff1d(np.arange(size), section.held)
    stiffness = _assembled(matrices, section.dofs, size)[free][:, free]
    gain = force[free].T @ splu(stiffness.tocsc()).solve(force[free]) - moved.T @ own
    return np.asarray((gain + gain.T) / 2)


def _shell_at_wall(section: "_PlaneStrain | _Antiplane") -> tuple[Array, Array]:
    """Return what the shell has at the wall for unit forces and moments of the ending layers.

    Returns
    -------
    strain : (2, 2 m) array of float
        Strain and curvature of the layers that carry what the others leave: those that go on, or,
        at a rim, all. The shear of antiplane shear is the same at all heights.
    tractions : (p, 2, 2 m) array of float
        Stress of each layer at its middle, Pa, and its slope over the height, Pa/m.
    """
    plies, modes = section.cells.plies, section.modes
    ends = np.array([ply.ends for ply in plies])
    carries = ends if ends.all() else ~ends
    thickness = np.array([ply.thickness for ply in plies])
    middle = np.array([ply.middle for ply in plies])
    stiff = np.array(section.moduli) * thickness
    parts = np.array([stiff, stiff * middle, stiff * (middle**2 + thickness**2 / 12)])
    a, b, d = parts[:, carries].sum(axis=1)
    count = 2 * ends.sum()
    resultants = np.zeros((2, count))
    resultants[0, ::2], resultants[1, ::2], resultants[1, 1::2] = 1.0, middle[ends], 1.0
    strain = np.zeros((2, count))
    strain[:modes] = -np.linalg.solve(
        np.array([[a, b], [b, d]])[:modes, :modes], resultants[:modes]
    )
    tractions = np.zeros((len(plies), 2, count))
    own = np.flatnonzero(ends), np.arange(count // 2)
    tractions[own[0], 0, 2 * own[1]] = 1 / thickness[ends]
    tractions[own[0], 1, 2 * own[1] + 1] = 12 / thickness[ends] ** 3
    modulus = np.where(carries, section.moduli, 0.0)[:, None]
    tractions[:, 0] += modulus * (strain[0] + middle[:, None] * strain[1])
    tractions[:, 1] += modulus * strain[1]
    return strain, tractions


def _wall_forces(section: "_PlaneStrain | _Antiplane", tractions: Array, size: int) -> Array:
    """Return the forces of tractions on the cells behind the wall, along x (or y), (dofs, k)."""
    cells, at_wall = section.cells, section.cells.at_wall
    ply, start, size_z = cells.ply[at_wall], cells.start[1, at_wall], cells.size[1, at_wall]
    middle = np.array([each.middle for each in cells.plies])[ply]
    height = (start + size_z / 2 - middle)[:, None] + size_z[:, None] / 2 * _AT
    stress = tractions[ply, 0][:, None] + height[:, :, None] * tractions[ply, 1][:, None]
    shape, _ = _shapes(_AT)
    force = np.einsum("m,q,aq,mqk->mak", size_z / 2, _WEIGHT, shape, stress)
    total = np.zeros((size, tractions.shape[2]))
    np.add.at(total, cells.node[at_wall][:, :3], force)
    return total


def _gradients(cells: _Cells) -> tuple[tuple[Array, Array], Array]:
    """Return the shape functions' slopes along x and z, (m, 9, 9), and the points' weights."""
    shape, slope = _shapes(_AT)
    by_x = np.einsum("aq,br->abqr", slope, shape).reshape(9, 9)
    by_z = np.einsum("aq,br->abqr", shape, slope).reshape(9, 9)
    width, height = cells.size
    weights = np.outer(width * height / 4, np.outer(_WEIGHT, _WEIGHT))
    return (np.multiply.outer(2 / width, by_x), np.multiply.outer(2 / height, by_z)), weights


def _shapes(at: Array) -> tuple[Array, Array]:
    """Return the parabolas of three nodes at places from -1 to 1, and their slopes, (3, q)."""
    shape = np.stack([at * (at - 1) / 2, 1 - at * at, at * (at + 1) / 2])
    return shape, np.stack([at - 0.5, -2 * at, at + 0.5])


def _product(weights: Array, rows: Array) -> Array:
    """Return the sum over q of weights (m, q) times rows (m, a, q) times themselves."""
    return np.asarray((weights[:, None] * rows) @ rows.transpose(0, 2, 1))


def _assembled(matrices: Array, dofs: Numbers, size: int) -> csc_matrix:
    rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    places = rows.reshape(-1), columns.reshape(-1)
    return csc_matrix((matrices.reshape(-1), places), shape=(size, size))


def _graded(length: float, first: float, growth: float) -> Array:
    """Return places from 0 to a length, ever farther apart."""
    count = int(np.ceil(np.log1p(length / first * (growth - 1)) / np.log(growth)))
    places = np.concatenate([[0.0], np.cumsum(growth ** np.arange(max(count, 1)))])
    return np.asarray(places / places[-1] * length)


def _both_ways(ply: Ply, first_cell: float, growth: float) -> Array:
    """Return the levels of a layer, closest at its bottom and at its top."""
    half = _graded(ply.thickness / 2, first_cell * ply.thickness, growth)
    return np.concatenate([ply.bottom + half, ply.top - half[-2::-1]])


def _at_halves(places: Array) -> Array:
    """Return places with the middles between them."""
    return np.interp(np.arange(0, 2 * len(places) - 1) / 2, np.arange(len(places)), places)
