"""Layers through the thickness: the energy per area of a shell from its strain and curvature.

The six components s = (Exx, Eyy, 2 Exy, kxx, kyy, 2 kxy) are the Green strain of the reference
surface and the change of its curvature (positive where it bulges toward +z), both from the flat
bonded state. A *profile* says which strain they make at a height z; a layer's material answers to
it; Gauss points through each layer, which need not contain the reference surface, add up.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mechanics.memory import Memory
from bilayer.specimen.relaxation import ELASTIC, PronySeries
from dshell.energies.wall_zones import WallZones
from dshell.materials.plane_stress import PlaneStressLaw, PlaneStressState
from dshell.materials.remembering import remember

Array = NDArray[np.float64]

GAUSS_POINTS = 3
"""In each layer; the energy is a polynomial of degree 2 in z, to first order in the strain."""
PROFILES = {"linear": 0.0, "quadratic": 1.0}
"""Weight g of the quadratic term in the strain at a height z, by the name a setting gives it:

    e = E + z k - g z^2 det(k) / 2  (in exx and eyy).

With the term, a fibre keeps its volume where the surface bends both ways. On the surface z along
the normals of one with mean curvature H and Gaussian curvature K, areas have grown by 1 + 2 H z. A
fibre that keeps its volume is thinner there, so what was drawn at z lies at z - H z^2. With that,
z k + z^2 k k / 2 becomes z k + z^2 (k k / 2 - H k), which is z k - z^2 K / 2 by the theorem of
Cayley and Hamilton: a cylinder has no quadratic term (as in Rivlin's flexure, where the Green
strain is linear in the drawn place), a sphere a negative one.
"""


@dataclass(frozen=True, eq=False)
class ShellLayer:
    """One layer of a shell with its natural state.

    Parameters
    ----------
    name : str
        What its energy is called in a result.
    law : PlaneStressLaw
        Its material.
    bottom, top : float
        Heights above the reference surface in the flat bonded state, m. The energy is integrated
        over them: a prestretch keeps the volume, so they hold the natural volume.
    prestretch : (2, 2) or (2, 2, k) array of float
        Stretch that the flat bonded state has from the natural one, symmetric; one for all faces
        or one for each that the layer covers.
    faces : (k,) array of int or None
        Faces that the layer covers, ascending; None: all.
    relaxation : PronySeries
        How its stress relaxes.
    memory : Memory or None
        What it remembers in the present step of time; None: it answers at once, as an elastic one.
    share : (k,) array of float or None
        Of the layer that lies on each face it covers, by which its energy counts; None: all.
    """

    name: str
    law: PlaneStressLaw
    bottom: float
    top: float
    prestretch: Array
    faces: NDArray[np.int64] | None = None
    relaxation: PronySeries = ELASTIC
    memory: Memory | None = None
    share: Array | None = None
    heights: Array = field(init=False)  # of the Gauss points, m, shape (q,)
    weights: Array = field(init=False)  # theirs, m

    def __post_init__(self) -> None:
        at, weight = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        middle, half = (self.top + self.bottom) / 2, (self.top - self.bottom) / 2
        object.__setattr__(self, "heights", middle + half * at)
        object.__setattr__(self, "weights", half * weight)
        if self.faces is not None and np.any(np.diff(self.faces) <= 0):
            raise InputError(f"faces of the layer {self.name}: expected in ascending order")
        S = np.asarray(self.prestretch, dtype=float)
        object.__setattr__(self, "prestretch", S if S.ndim == 3 else S[:, :, None])

    @property
    def face_numbers(self) -> "NDArray[np.int64] | slice":
        """Index of the faces that the layer covers."""
        return slice(None) if self.faces is None else self.faces

    def part(self, block: slice) -> "ShellLayer":
        """Return the layer on some of the faces, which are numbered anew."""
        if self.faces is None:
            inside, faces = block, None
        else:
            inside = slice(*np.searchsorted(self.faces, [block.start, block.stop]))
            faces = self.faces[inside] - block.start
        each = self.prestretch.shape[2] > 1
        return replace(
            self,
            faces=faces,
            prestretch=self.prestretch[:, :, inside] if each else self.prestretch,
            memory=None if self.memory is None else self.memory.part(inside),
            share=None if self.share is None else self.share[inside],
        )


@dataclass(frozen=True, eq=False)
class Laminate:
    """Layers that share a reference surface.

    Parameters
    ----------
    layers : sequence of ShellLayer
        From the same reference surface.
    quadratic : float
        Weight of the quadratic term of the strain, see `PROFILES`.
    zones : WallZones or None
        Beside the walls where layers end; None: the layers are strained up to there.
    """

    layers: Sequence[ShellLayer]
    quadratic: float
    zones: WallZones | None = None

    @property
    def thickness(self) -> float:
        """From the bottom of the lowest layer to the top of the highest, m."""
        return max(layer.top for layer in self.layers) - min(layer.bottom for layer in self.layers)

    def part(self, block: slice) -> "Laminate":
        """Return the laminate of some of the faces, a range."""
        zones = None if self.zones is None else self.zones.part(block)
        return replace(self, layers=[layer.part(block) for layer in self.layers], zones=zones)

    def at(self, s: Array) -> "BentLaminate":
        """Return the laminate in the strains and curvatures s of m faces, shape (6, m)."""
        return BentLaminate(self, s)


class BentLaminate:
    """A laminate's energy per area of the flat bonded state, and its derivatives by s.

    Parameters
    ----------
    laminate : Laminate
        What is bent.
    s : (6, m) array of float
        Strain and curvature of each face.
    """

    def __init__(self, laminate: Laminate, s: Array) -> None:
        self._zones, self._strains = laminate.zones, s
        if laminate.zones is not None:
            s = laminate.zones.layer_strains(s)
        self.layers = [
            BentLayer(layer, laminate.quadratic, s[:, layer.face_numbers])
            for layer in laminate.layers
        ]

    def energy(self) -> Array:
        """Return the energy per area, J/m2, shape (m,)."""
        total = self.zone_energy()
        for bent in self.layers:
            total[bent.layer.face_numbers] += bent.energy()
        return total

    def zone_energy(self) -> Array:
        """Return the part of the zones beside walls, J/m2, shape (m,)."""
        if self._zones is None:
            return np.zeros(self._strains.shape[1:])
        return self._zones.energy(self._strains)

    def resultants(self) -> Array:
        """Return its derivative by s, membrane forces (N/m) and moments (N), shape (6, m)."""
        total = np.zeros(self._strains.shape)
        for bent in self.layers:
            total[:, bent.layer.face_numbers] += bent.resultants()
        return total if self._zones is None else self._zones.resultants(self._strains, total)

    def stiffness(self) -> Array:
        """Return the resultants' own derivative by s, shape (6, 6, m)."""
        total = np.zeros((6, *self._strains.shape))
        for bent in self.layers:
            total[:, :, bent.layer.face_numbers] += bent.stiffness()
        return total if self._zones is None else self._zones.stiffness(total)


class BentLayer:
    """One layer in s of shape (6, k); all its Gauss points at once, in the last axis but one.

    With d the derivative of det(k) by k, the derivative of the strain by the curvature is
    z - g z^2 / 2 (1, 1, 0) (x) d, so the resultants need the moments of the stress up to z^2 and
    the stiffness those of the tangent up to z^4.
    """

    def __init__(self, layer: ShellLayer, quadratic: float, s: Array) -> None:
        self.layer = layer
        self._half = 0.5 * quadratic
        x, y, twist = s[3:]
        self._det_slope = np.stack([y, x, -0.5 * twist])
        self._det = x * y - 0.25 * twist * twist
        self._strains = s
        self._material = self.at_heights(layer.heights, layer.memory)

    def strain(self, heights: Array) -> Array:
        """Return the strain from the flat bonded state at heights (q,), shape (3, q, k)."""
        z, s = heights[:, None], self._strains
        strain: Array = s[:3, None] + z * s[3:, None]
        strain[:2] -= self._half * z**2 * self._det
        return strain

    def instantaneous(self, memory: Memory) -> Array:
        """Return the stresses to remember at the Gauss points, Pa, (parts, q, k).

        They are those that the law has at once, in the stretch of the thickness that it has with
        the memory of the step.
        """
        layer = self.layer
        strain = self.strain(layer.heights)
        return remember(layer.law, strain, layer.prestretch, memory).instantaneous()

    def at_heights(self, heights: Array, memory: Memory | None = None) -> PlaneStressState:
        """Return the material at heights (q,), m; without a memory, as it answers at once."""
        strain, prestretch = self.strain(heights), self.layer.prestretch
        if memory is None:
            return self.layer.law.at(strain, prestretch)
        return remember(self.layer.law, strain, prestretch, memory)

    def law_energy(self) -> Array:
        """Return the energy per area that the law has at once in the strains, J/m2, (k,)."""
        return self._shared(self.layer.weights @ self.at_heights(self.layer.heights).energy())

    def energy(self) -> Array:
        """Return the energy per area, J/m2, shape (k,)."""
        return self._shared(self.layer.weights @ self._material.energy())

    def resultants(self) -> Array:
        """Return its derivative by s, shape (6, k)."""
        zeroth, first, second = self._stress_moments
        moments = first - self._half * (second[0] + second[1]) * self._det_slope
        return np.concatenate([zeroth, moments])

    def stiffness(self) -> Array:
        """Return the resultants' own derivative by s, shape (6, 6, k)."""
        zeroth, first, second, third, fourth = self._moments(self._material.tangent(), 4)
        slope = self._half * self._det_slope
        both = (fourth[0] + fourth[1])[:2].sum(axis=0)
        mixed = first - (second[:, 0] + second[:, 1])[:, None] * slope
        crossed = (third[:, 0] + third[:, 1])[:, None] * slope
        bending = second - crossed - crossed.transpose(1, 0, 2)
        bending += both * slope[:, None] * slope
        pull = self._half * self._stress_moments[2, :2].sum(axis=0)
        bending[0, 1] -= pull
        bending[1, 0] -= pull
        bending[2, 2] += 0.5 * pull
        upper = np.concatenate([zeroth, mixed], axis=1)
        lower = np.concatenate([mixed.transpose(1, 0, 2), bending], axis=1)
        return np.concatenate([upper, lower])

    @cached_property
    def _stress_moments(self) -> Array:
        return self._moments(self._material.stress(), 2)

    def _moments(self, density: Array, highest: int) -> Array:
        """Return the integrals of z^0, z^1, ... times a density (..., q, k), in a first axis."""
        powers = self.layer.weights * self.layer.heights ** np.arange(highest + 1)[:, None]
        return self._shared(np.moveaxis(powers @ density, -2, 0))

    def _shared(self, per_area: Array) -> Array:
        """Return what a whole layer has per area, (..., k), by the share that lies there."""
        share = self.layer.share
        return per_area if share is None else np.asarray(share * per_area)
