"""Layers through the thickness: the energy per area of a shell from its strain and curvature.

The six components s = (Exx, Eyy, 2 Exy, kxx, kyy, 2 kxy) are the Green strain of the reference
surface and the change of its curvature (positive where it bulges toward +z), both from the flat
bonded state. A *profile* says which strain they make at a height z; a layer's material answers to
it; Gauss points through each layer, which need not contain the reference surface, add up.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from dshell.plane_stress import PlaneStressLaw

Array = NDArray[np.float64]

GAUSS_POINTS = 3
"""In each layer; the energy is a polynomial of degree 2 in z, to first order in the strain."""


class Profile(Protocol):
    """The strain at a height z above the reference surface, from s of shape (6, m).

    It is the surface's own strain (s[:3]) and what its curvature (s[3:]) adds to that.
    """

    def strain(self, s: Array, z: float) -> Array:
        """Return the strain (exx, eyy, 2 exy), shape (3, m)."""

    def slope(self, s: Array, z: float) -> Array:
        """Return its derivative by the curvature, shape (3, 3, m) or (3, 3, 1)."""

    def bend(self, s: Array, z: float, stress: Array) -> Array:
        """Return its second derivative by the curvature times a stress of shape (3, m).

        The shape is that of the slope.
        """


class LinearProfile:
    """e = E + z k."""

    def strain(self, s: Array, z: float) -> Array:
        """See `Profile`."""
        return s[:3] + z * s[3:]

    def slope(self, s: Array, z: float) -> Array:
        """See `Profile`."""
        return z * np.eye(3)[:, :, None]

    def bend(self, s: Array, z: float, stress: Array) -> Array:
        """See `Profile`."""
        return np.zeros((3, 3, 1))


class QuadraticProfile:
    """e = E + z k - z^2 det(k) / 2: a fibre keeps its volume where the surface bends both ways.

    On the surface z along the normals of one with mean curvature H and Gaussian curvature K, areas
    have grown by 1 + 2 H z. A fibre that keeps its volume is thinner there, so what was drawn at z
    lies at z - H z^2. With that, z k + z^2 k k / 2 becomes z k + z^2 (k k / 2 - H k), which is
    z k - z^2 K / 2 by the theorem of Cayley and Hamilton: a cylinder has no quadratic term (as in
    Rivlin's flexure, where the Green strain is linear in the drawn place), a sphere a negative one.
    """

    def strain(self, s: Array, z: float) -> Array:
        """See `Profile`."""
        x, y, g = s[3:]
        gaussian = x * y - g * g / 4
        return s[:3] + z * s[3:] - 0.5 * z**2 * np.stack([gaussian, gaussian, 0 * g])

    def slope(self, s: Array, z: float) -> Array:
        """See `Profile`."""
        x, y, g = s[3:]
        slope = np.zeros((3, 3, s.shape[1]))
        slope[:2] = -0.5 * z**2 * np.stack([y, x, -g / 2])
        for component in range(3):
            slope[component, component] += z
        return slope

    def bend(self, s: Array, z: float, stress: Array) -> Array:
        """See `Profile`."""
        bend = np.zeros((3, 3, s.shape[1]))
        both = -0.5 * z**2 * (stress[0] + stress[1])
        bend[0, 1] = bend[1, 0] = both
        bend[2, 2] = np.divide(both, -2)
        return bend


PROFILES: dict[str, type[Profile]] = {"linear": LinearProfile, "quadratic": QuadraticProfile}
"""Profiles by the name that a setting gives them."""


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
        Faces that the layer covers; None: all.
    """

    name: str
    law: PlaneStressLaw
    bottom: float
    top: float
    prestretch: Array
    faces: NDArray[np.int64] | None = None
    points: tuple[tuple[float, float], ...] = field(init=False)  # heights and weights

    def __post_init__(self) -> None:
        at, weight = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        middle, half = (self.top + self.bottom) / 2, (self.top - self.bottom) / 2
        pairs = zip(middle + half * at, half * weight, strict=True)
        object.__setattr__(self, "points", tuple((float(z), float(w)) for z, w in pairs))
        S = np.asarray(self.prestretch, dtype=float)
        object.__setattr__(self, "prestretch", S if S.ndim == 3 else S[:, :, None])

    @property
    def covered(self) -> "NDArray[np.int64] | slice":
        """Index of the faces that the layer covers."""
        return slice(None) if self.faces is None else self.faces


@dataclass(frozen=True, eq=False)
class Laminate:
    """Layers that share a reference surface: energy per area of the flat bonded state.

    Parameters
    ----------
    layers : sequence of ShellLayer
        From the same reference surface.
    profile : Profile
        How strain varies through the thickness.
    """

    layers: Sequence[ShellLayer]
    profile: Profile

    @property
    def thickness(self) -> float:
        """From the bottom of the lowest layer to the top of the highest, m."""
        return max(layer.top for layer in self.layers) - min(layer.bottom for layer in self.layers)

    def layer_energy(self, layer: ShellLayer, s: Array) -> Array:
        """Return one layer's energy per area, J/m2, shape (k,), from s on the k faces it covers."""
        total = np.zeros(s.shape[1])
        for z, weight in layer.points:
            total += weight * layer.law.energy(self.profile.strain(s, z), layer.prestretch)
        return total

    def energy(self, s: Array) -> Array:
        """Return the energy per area, J/m2, shape (m,), from s of shape (6, m)."""
        total = np.zeros(s.shape[1])
        for layer in self.layers:
            total[layer.covered] += self.layer_energy(layer, s[:, layer.covered])
        return total

    def resultants(self, s: Array) -> Array:
        """Return its derivative by s, membrane forces (N/m) and moments (N), shape (6, m)."""
        total = np.zeros(s.shape)
        for layer in self.layers:
            total[:, layer.covered] += self._layer_resultants(layer, s[:, layer.covered])
        return total

    def resultants_and_stiffness(self, s: Array) -> tuple[Array, Array]:
        """Return the resultants with their own derivative by s, shape (6, 6, m)."""
        resultants, stiffness = np.zeros(s.shape), np.zeros((6, 6, s.shape[1]))
        for layer in self.layers:
            here, stiff = self._layer_response(layer, s[:, layer.covered])
            resultants[:, layer.covered] += here
            stiffness[:, :, layer.covered] += stiff
        return resultants, stiffness

    def _layer_resultants(self, layer: ShellLayer, s: Array) -> Array:
        total = np.zeros(s.shape)
        for z, weight in layer.points:
            stress = layer.law.stress(self.profile.strain(s, z), layer.prestretch)
            self._add_stress(total, weight * stress, self.profile.slope(s, z))
        return total

    def _layer_response(self, layer: ShellLayer, s: Array) -> tuple[Array, Array]:
        resultants, stiffness = np.zeros(s.shape), np.zeros((6, 6, s.shape[1]))
        for z, weight in layer.points:
            strain, slope = self.profile.strain(s, z), self.profile.slope(s, z)
            stress, tangent = layer.law.stress_and_tangent(strain, layer.prestretch)
            stress, tangent = weight * stress, weight * tangent
            self._add_stress(resultants, stress, slope)
            mixed = np.einsum("ijm,jbm->ibm", tangent, slope)
            stiffness[:3, :3] += tangent
            stiffness[:3, 3:] += mixed
            stiffness[3:, 3:] += np.einsum("iam,ibm->abm", slope, mixed)
            stiffness[3:, 3:] += self.profile.bend(s, z, stress)
        stiffness[3:, :3] = stiffness[:3, 3:].transpose(1, 0, 2)
        return resultants, stiffness

    @staticmethod
    def _add_stress(resultants: Array, stress: Array, slope: Array) -> None:
        resultants[:3] += stress
        resultants[3:] += np.einsum("iam,im->am", slope, stress)
