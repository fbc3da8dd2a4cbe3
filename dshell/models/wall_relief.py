"""The zones beside the walls where layers end, as they act on the faces of a shell.

By the theory of plates a wall takes d.C d / 2 from the energy per length (`dshell.models.
wall_section`), d the forces and moments of the layers that end there. They follow from m, those of
all layers together, and from what the wall leaves as it is, by d = d0 + T m. So the sheet gives way
at the wall by T'C d0, and by T'C T m more under m. On the faces that share the wall, this is a zone
in series with the layers. With the stiffness D of these, their natural strain s0, and the length f
of wall over the area of the faces, the strain s of a face leaves to the layers s1,

    s = s1 + f T'C (d0 + T m),    m = D (s1 - s0),

and to their energy per area the zone adds f (m.T'C T m - d0.C d0) / 2. The layers have their own
laws; D, s0 and m of the zone are those of small strain about the natural state of each layer. That
is exact to first order in f, and stable beyond.

Two parts of the strain have such zones, s being what varies freely at the wall, t what does not:

- across the wall: s strain and curvature across it, t those along it;
- along it: s the shear, t the twist. Its stiffness loses f d0.C d0. So that it stays positive in a
  narrow strip, the share q that is lost is taken as tanh q. St. Venant's torsion of a rectangle
  follows that within 3 % of the full stiffness, whatever its width.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.specimen.materials import Law
from dshell.energies.through_thickness import ShellLayer
from dshell.energies.wall_zones import WallZones
from dshell.models.wall_faces import WallFaces
from dshell.models.wall_section import Ply, wall_compliance

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

NATURAL_STEPS = 4
"""Of Newton's method for a layer's natural strain, which begins at that of a hyperelastic law."""
LEAST_GIVE = -0.5
"""Of a zone over that of the layers; a wall that stiffens has a negative one."""


def wall_zones(
    layers: Sequence[ShellLayer],
    materials: Mapping[str, Law],
    walls: Sequence[WallFaces],
    face_count: int,
) -> WallZones:
    """Return the zones beside walls.

    Parameters
    ----------
    layers : sequence of ShellLayer
        From the bottom up.
    materials : mapping of str to Law
        The law of each layer, by its name.
    walls : sequence of WallFaces
        Of the mesh of the layers.
    face_count : int
        Of that mesh.
    """
    matrix, form = np.zeros((2, 7, 7, face_count))
    matrix[np.arange(7), np.arange(7)] = 1.0
    for wall in walls:
        there = [layer for layer in layers if layer.name in wall.there]
        plies = tuple(_ply(layer, materials[layer.name], wall.ending) for layer in there)
        compliance = wall_compliance(plies)
        natural = [_natural_on(layer, wall.faces, face_count) for layer in there]
        for number in range(2):
            normal, density = wall.normals[:, number], wall.density[number]
            left = matrix[:, :, wall.faces]
            across = _across(plies, normal, natural).zone(compliance.across, density, left)
            along = _along(plies, normal, natural)
            shared = along.bounded(compliance.along, density)
            along_too = along.zone(compliance.along, shared, left)
            matrix[:, :, wall.faces] += across.matrix + along_too.matrix
            form[:, :, wall.faces] += across.form + along_too.form
    return WallZones(matrix, form)


@dataclass(frozen=True, eq=False)
class _Part:
    """A part of the strain: the resultants of s and the drives d as maps of x = (s, t, 1).

    Parameters
    ----------
    forces : (s, p, k) array of float
        Resultants m of all layers.
    drives : (2 e, p, k) array of float
        Forces and moments d of those that end.
    kept : float
        Stiffness of all layers against the first t, with s held.
    rows : (p, 7, k) array of float
        x from (strain, curvature, 1) of the face.
    units : (7, s, k) array of float
        Strain and curvature of each s.
    """

    forces: Array
    drives: Array
    kept: float
    rows: Array
    units: Array

    def zone(self, compliance: Array, density: Array, left: Array) -> WallZones:
        """Return a zone: what it takes away, and its energy, both as maps of the face's (s, 1).

        Parameters
        ----------
        compliance : (2 e, 2 e) array of float
            C.
        density : (k,) array of float
            f, 1/m.
        left : (7, 7, k) array of float
            What other zones have left to the layers.
        """
        x = np.einsum("pak,abk->pbk", self.rows, left)
        drives = np.einsum("apk,pbk->abk", self._unforced, x)
        strain = np.einsum("fg,gpk,pbk->fbk", np.linalg.inv(self._stiffness), self.forces, x)
        given = np.einsum("fa,abk->fbk", self._share.T @ compliance, drives)
        root = np.linalg.cholesky(self._stiffness)
        give, modes = np.linalg.eigh(root.T @ self._share.T @ compliance @ self._share @ root)
        zone = np.maximum(np.outer(give, density), LEAST_GIVE)
        modal = np.einsum("fm,fbk->mbk", root @ modes, strain - density * given)
        modal /= (1 + zone)[:, None]
        own = np.einsum("fm,mbk->fbk", np.linalg.inv(root.T) @ modes, modal)
        form = np.einsum("mk,mak,mbk->abk", zone, modal, modal)
        form -= density * np.einsum("apk,ab,bqk->pqk", drives, compliance, drives)
        return WallZones(np.einsum("afk,fbk->abk", self.units, own - strain), form)

    def bounded(self, compliance: Array, density: Array) -> Array:
        """Return the density that does not let the stiffness against t become negative, (k,)."""
        t = len(self.forces)
        coupling, drive = self.forces[:, t, 0], self._unforced[:, t, 0]
        stiff = self.kept - coupling @ np.linalg.solve(self._stiffness, coupling)
        loss = np.maximum(density * (drive @ compliance @ drive) / stiff, 1e-12)
        return np.asarray(density * np.tanh(loss) / loss)

    @property
    def _stiffness(self) -> Array:
        """D, (s, s)."""
        return self.forces[:, : len(self.forces), 0]

    @property
    def _share(self) -> Array:
        """T, (2 e, s)."""
        return self.drives[:, : len(self.forces), 0] @ np.linalg.inv(self._stiffness)

    @property
    def _unforced(self) -> Array:
        """d0 as a map of x, (2 e, p, k)."""
        return self.drives - np.einsum("af,fpk->apk", self._share, self.forces)


def _across(plies: Sequence[Ply], normal: Array, natural: Sequence[Array]) -> _Part:
    """Return strain and curvature across a wall; kept are those along it."""
    x, y = normal
    across, along = np.stack([x * x, y * y, x * y]), np.stack([y * y, x * x, -x * y])
    maps = []
    for ply, strain in zip(plies, natural, strict=True):
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
    return _part(plies, maps, rows, units)


def _along(plies: Sequence[Ply], normal: Array, natural: Sequence[Array]) -> _Part:
    """Return the shear along a wall; kept is the twist."""
    x, y = normal
    row = np.stack([-2 * x * y, 2 * x * y, x * x - y * y])
    maps = []
    for ply, strain in zip(plies, natural, strict=True):
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
    return _part(plies, maps, rows, units)


def _part(
    plies: Sequence[Ply], maps: Sequence[tuple[Array, Array]], rows: Array, units: Array
) -> _Part:
    """Return a part of the strain from the force and the moment of each layer."""
    force, moment = np.zeros((2, *maps[0][0].shape))
    for ply, (own_force, own_moment) in zip(plies, maps, strict=True):
        force += own_force
        moment += ply.middle * own_force + own_moment
    drives = [each for ply, pair in zip(plies, maps, strict=True) if ply.ends for each in pair]
    forces = np.stack([force, moment])[: units.shape[1]]
    return _Part(forces, np.stack(drives), moment[1, 0], rows, units)


def _ply(layer: ShellLayer, material: Law, ending: frozenset[str]) -> Ply:
    """Return a layer in the section across a wall."""
    moduli = material.young_modulus, material.poisson_ratio
    return Ply(layer.bottom, layer.top, *moduli, layer.name in ending)


def _natural_on(layer: ShellLayer, faces: Numbers, face_count: int) -> Array:
    """Return the natural strain of a layer on some of the faces that it covers, (3, 1 or k)."""
    strain = natural_strain(layer)
    if strain.shape[1] == 1:
        return strain
    return strain[:, np.searchsorted(np.arange(face_count)[layer.face_numbers], faces)]


def natural_strain(layer: ShellLayer) -> Array:
    """Return the strain from the flat bonded state at which a layer has no stress, (3, k).

    k is 1 if the prestretch is the same on all faces.
    """
    inverse = np.linalg.inv(np.moveaxis(layer.prestretch, 2, 0))
    metric = np.moveaxis(inverse @ inverse, 0, 2)
    strain = np.stack([(metric[0, 0] - 1) / 2, (metric[1, 1] - 1) / 2, metric[0, 1]])
    for _ in range(NATURAL_STEPS):  # one that is not hyperelastic has it elsewhere
        state = layer.law.at(strain, layer.prestretch)
        tangent = np.moveaxis(state.tangent(), 2, 0)
        strain = strain - np.linalg.solve(tangent, state.stress().T[:, :, None])[:, :, 0].T
    return strain
