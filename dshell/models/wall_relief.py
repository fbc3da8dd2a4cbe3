"""The zones beside the walls where layers end, as they act on the faces of a shell.

By the theory of plates a wall takes d.C d / 2 from the energy per length (`dshell.models.
wall_section`), d the forces and moments of the layers that end there. They follow from m, those
that all layers together hand over at the wall, and from what the wall leaves as it is, by
d = d0 + T m. So the energy per length is less by d0.C d0 / 2, and the sheet gives way at the wall
by T'C d0, and by T'C T m more under m. With the length f of wall over the area of the faces that
share it,

- the faces behind the wall, where the layers end, lose f d0.C d0 / 2 of their energy per area;
- on those before it a zone is in series with the layers that go on. With their stiffness D and
  their natural strain s0, the strain s of a face leaves to the layers s1,

      s = s1 + f T'C (d0 + T m),    m = D (s1 - s0),

  and the zone adds f m.T'C T m / 2 to their energy per area.

The layers have their own laws; D, s0 and m of the zone are linear between the natural state of each
layer and the flat bonded one. That is exact to first order in the thickness over the width of a
strip. At a rim m is zero, and nothing gives way.

Two parts of the strain have such zones, s being what varies freely at the wall, t what does not:

- across the wall: s strain and curvature across it, t those along it; the energy f d0.C d0 / 2 is
  that of layers that do not fit together;
- along it: s the shear, t the twist; the energy is that of twist.

In a narrow strip no more can be lost than there is, so a share q, of all walls of a face, is taken
as tanh q. St. Venant's torsion of a rectangle follows that within 3 % of the full stiffness,
whatever its width.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dshell.energies.through_thickness import ShellLayer
from dshell.energies.wall_zones import WallZones
from dshell.models.wall_faces import WallFaces
from dshell.models.wall_section import Ply, WallCompliance, wall_compliance

Array = NDArray[np.float64]

NATURAL_STEPS = 4
"""Of Newton's method for a layer's natural strain, which begins at that of a hyperelastic law."""
ROUND_OFF = 1e-12
"""Share of a stiffness that is none."""
LEAST_GIVE = -0.5
"""Of a zone over that of the layers; a wall that stiffens has a negative one."""


def wall_zones(
    layers: Sequence[ShellLayer],
    walls: Sequence[WallFaces],
    face_count: int,
) -> WallZones:
    """Return the zones beside walls.

    Parameters
    ----------
    layers : sequence of ShellLayer
        From the bottom up, each with one prestretch on all its faces.
    walls : sequence of WallFaces
        Of the mesh of the layers.
    face_count : int
        Of that mesh.
    """
    matrix, form = np.zeros((2, 7, 7, face_count))
    matrix[np.arange(7), np.arange(7)] = 1.0
    sides = [_Sides.of(wall, layers) for wall in walls]
    for part in (_across, _along):
        share = np.zeros(face_count)
        for side in sides:
            for behind, density in side.behind(part):
                share[side.wall.behind.faces] += behind.loss(side.compliance) * density
        left = np.tanh(share) / np.where(share > 0, share, 1.0)
        for side in sides:
            _lose(form, side, part, left)
            _give_way(matrix, form, side, part)
    return WallZones(matrix, form)


_Stack = Sequence[tuple[Ply, Array]]
"""Layers on faces, each with its natural strain (3, 1)."""


@dataclass(frozen=True, eq=False)
class _Sides:
    """Walls of one kind with the layers on both sides.

    Parameters
    ----------
    wall : WallFaces
        The faces there.
    there, beyond : stack of layers
        On them.
    compliance : WallCompliance
        Of the walls.
    """

    wall: WallFaces
    there: _Stack
    beyond: _Stack
    compliance: WallCompliance

    @classmethod
    def of(cls, wall: WallFaces, layers: Sequence[ShellLayer]) -> "_Sides":
        """Return the sides of walls."""
        there, beyond = (
            [_in_stack(layer, wall.ending) for layer in layers if layer.name in names]
            for names in (wall.there, wall.beyond)
        )
        return cls(wall, there, beyond, wall_compliance(tuple(ply for ply, _ in there)))

    def behind(self, make: "_Maker") -> Iterator[tuple["_Part", Array]]:
        """Yield a part of the strain behind the walls, and their density, for each direction."""
        shared = self.wall.behind
        for number in range(2):
            yield make(self.there, shared.normals[:, number]), shared.density[number]

    def before(self, make: "_Maker") -> Iterator[tuple["_Part", "_Part", Array]]:
        """Yield the same before the walls, of the layers behind and of those there."""
        shared = self.wall.before
        for number in range(2 if self.beyond else 0):
            normal, density = shared.normals[:, number], shared.density[number]
            yield make(self.there, normal), make(self.beyond, normal), density


def _lose(form: Array, sides: _Sides, make: "_Maker", left: Array) -> None:
    """Take from the faces behind walls what these lose of their energy.

    `left`, for all faces, is what is lost over what is by small losses.
    """
    faces = sides.wall.behind.faces
    for part, density in sides.behind(make):
        drives = np.einsum("apk,pbk->abk", part.unforced, part.rows)
        given = np.einsum("ab,bqk->aqk", part.of(sides.compliance), drives)
        form[:, :, faces] -= left[faces] * density * np.einsum("apk,aqk->pqk", drives, given)


def _give_way(matrix: Array, form: Array, sides: _Sides, make: "_Maker") -> None:
    """Put zones in series with the layers on the faces before walls."""
    faces = sides.wall.before.faces
    for ending, own, density in sides.before(make):
        x = np.einsum("pak,abk->pbk", own.rows, matrix[:, :, faces])
        share, stiff = ending.share, own.stiffness
        given = share.T @ ending.of(sides.compliance)
        strain = np.einsum("fg,gpk,pbk->fbk", np.linalg.inv(stiff), own.forces, x)
        free = strain - density * np.einsum("fa,apk,pbk->fbk", given, ending.unforced, x)
        root = np.linalg.cholesky(stiff)
        give, modes = np.linalg.eigh(root.T @ given @ share @ root)
        zone = np.maximum(np.outer(give, density), LEAST_GIVE)
        modal = np.einsum("fm,fbk->mbk", root @ modes, free) / (1 + zone)[:, None]
        held = np.einsum("fm,mbk->fbk", np.linalg.inv(root.T) @ modes, modal)
        matrix[:, :, faces] += np.einsum("afk,fbk->abk", own.units, held - strain)
        form[:, :, faces] += np.einsum("mk,mak,mbk->abk", zone, modal, modal)


@dataclass(frozen=True, eq=False)
class _Part:
    """A part of the strain: the resultants of s and the drives d as maps of x = (s, t, 1).

    Parameters
    ----------
    name : {"across", "along"}
        Which part.
    forces : (s, p, k) array of float
        Resultants m of all layers.
    drives : (2 e, p, k) array of float
        Forces and moments d of those that end.
    lost : sequence of ((2 e,) array of float, float)
        What can be lost: states with s free, by their drives d0, and twice their energy per area.
    rows : (p, 7, k) array of float
        x from (strain, curvature, 1) of the face.
    units : (7, s, k) array of float
        Strain and curvature of each s.
    """

    name: str
    forces: Array
    drives: Array
    lost: Sequence[tuple[Array, float]]
    rows: Array
    units: Array

    def of(self, compliance: WallCompliance) -> Array:
        """Return C."""
        found: Array = getattr(compliance, self.name)
        return found

    def loss(self, compliance: WallCompliance) -> float:
        """Return the largest share of an energy that a wall takes over its density, m."""
        losses = [
            float(drive @ self.of(compliance) @ drive) / stiff
            for drive, stiff in self.lost
            if stiff > ROUND_OFF * self.stiffness[0, 0]
        ]
        return max(losses, default=0.0)

    @property
    def stiffness(self) -> Array:
        """D, (s, s)."""
        return self.forces[:, : len(self.forces), 0]

    @property
    def share(self) -> Array:
        """T, (2 e, s)."""
        return self.drives[:, : len(self.forces), 0] @ np.linalg.inv(self.stiffness)

    @property
    def unforced(self) -> Array:
        """d0 as a map of x, (2 e, p, k)."""
        return self.drives - np.einsum("af,fpk->apk", self.share, self.forces)


_Maker = Callable[[_Stack, Array], _Part]


def _across(stack: _Stack, normal: Array) -> _Part:
    """Return strain and curvature across a wall.

    What can be lost is the energy of a layer that is longer than the others.
    """
    x, y = normal
    across, along = np.stack([x * x, y * y, x * y]), np.stack([y * y, x * x, -x * y])
    maps = []
    for ply, strain in stack:
        force, moment = np.zeros((2, 5, len(x)))
        ratio, middle = ply.poisson_ratio, ply.middle
        force[:4] = np.array([1.0, middle, ratio, ratio * middle])[:, None]
        force[4] = -((across + ratio * along) * strain).sum(axis=0)
        moment[[1, 3]] = np.array([1.0, ratio])[:, None]
        maps.append((ply.plane_strain_modulus * ply.thickness * force,
                     ply.plane_strain_modulus * ply.thickness**3 / 12 * moment))  # fmt: skip
    units = np.zeros((7, 2, len(x)))
    units[:3, 0] = units[3:6, 1] = np.stack([x * x, y * y, 2 * x * y])
    rows = np.zeros((5, 7, len(x)))
    rows[0, :3] = rows[1, 3:6] = across
    rows[2, :3] = rows[3, 3:6] = along
    rows[4, 6] = 1.0
    return _part("across", stack, maps, rows, units)


def _along(stack: _Stack, normal: Array) -> _Part:
    """Return the shear along a wall. What can be lost is the energy of twist."""
    x, y = normal
    row = np.stack([-2 * x * y, 2 * x * y, x * x - y * y])
    maps = []
    for ply, strain in stack:
        force, moment = np.zeros((2, 3, len(x)))
        force[:2] = np.array([1.0, ply.middle])[:, None]
        force[2] = -(row * strain).sum(axis=0)
        moment[1] = 1.0
        maps.append((ply.shear_modulus * ply.thickness * force,
                     ply.shear_modulus * ply.thickness**3 / 12 * moment))  # fmt: skip
    units = np.zeros((7, 1, len(x)))
    units[:3, 0] = np.stack([-x * y, x * y, x * x - y * y])
    rows = np.zeros((3, 7, len(x)))
    rows[0, :3] = rows[1, 3:6] = row
    rows[2, 6] = 1.0
    return _part("along", stack, maps, rows, units)


def _part(
    name: str, stack: _Stack, maps: Sequence[tuple[Array, Array]], rows: Array, units: Array
) -> _Part:
    """Return a part of the strain from the force and the moment of each layer."""
    force, moment = np.zeros((2, *maps[0][0].shape))
    for (ply, _), (own_force, own_moment) in zip(stack, maps, strict=True):
        force += own_force
        moment += ply.middle * own_force + own_moment
    pairs = [pair for (ply, _), pair in zip(stack, maps, strict=True) if ply.ends]
    drives = np.array([each for pair in pairs for each in pair]).reshape(-1, *force.shape)
    forces = np.stack([force, moment])[: units.shape[1]]
    part = _Part(name, forces, drives, (), rows, units)
    lost = _of_twist(part, moment) if name == "along" else _of_layers(part)
    return replace(part, lost=lost)


def _of_twist(part: _Part, moment: Array) -> list[tuple[Array, float]]:
    """Return the drives of a twist of 1, and twice its energy per area."""
    coupling = part.forces[:, 1, 0]
    stiff = moment[1, 0] - coupling @ np.linalg.solve(part.stiffness, coupling)
    return [(part.unforced[:, 1, 0], float(stiff))]


def _of_layers(part: _Part) -> list[tuple[Array, float]]:
    """Return the drives of each layer that ends, longer by 1, and twice its energy per area."""
    found = []
    for number in range(0, len(part.drives), 2):
        own = part.drives[number, :2, 0]  # A (1, z): by strain and by curvature
        drive = part.share @ own
        drive[number] -= own[0]
        found.append((drive, float(own[0] - own @ np.linalg.solve(part.stiffness, own))))
    return found


def _in_stack(layer: ShellLayer, ending: frozenset[str]) -> tuple[Ply, Array]:
    """Return a layer in the section across a wall, and its natural strain.

    It has the Poisson's ratio of its natural state. The modulus leads from there straight to its
    stress in the flat bonded state, so it follows a large prestretch. Moduli along two axes of
    different prestretch are averaged.
    """
    natural = natural_strain(layer)
    tangent = layer.law.at(natural, layer.prestretch).tangent()[:, :, 0]
    stress = layer.law.at(np.zeros((3, 1)), layer.prestretch).stress()[:, 0]
    modulus = (tangent[0, 0] + tangent[1, 1]) / 2
    ratio = tangent[0, 1] / modulus
    linear = float(natural[:, 0] @ tangent @ natural[:, 0])
    if linear > 0:
        modulus *= -float(stress @ natural[:, 0]) / linear
    moduli = float(modulus * (1 - ratio**2)), float(ratio)
    return Ply(layer.bottom, layer.top, *moduli, layer.name in ending), natural


def natural_strain(layer: ShellLayer) -> Array:
    """Return the strain from the flat bonded state at which a layer has no stress, (3, 1)."""
    inverse = np.linalg.inv(layer.prestretch[:, :, 0])
    metric = inverse @ inverse
    strain = np.array([[metric[0, 0] - 1], [metric[1, 1] - 1], [2 * metric[0, 1]]]) / 2
    for _ in range(NATURAL_STEPS):  # one that is not hyperelastic has it elsewhere
        state = layer.law.at(strain, layer.prestretch)
        strain = strain - np.linalg.solve(state.tangent()[:, :, 0], state.stress())
    return strain
