"""The zones beside the walls where layers end, in series with the layers of a shell's faces."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WallZones:
    """What zones take of the strain and curvature s of each face, and their own energy.

    Parameters
    ----------
    matrix : (7, 7, m) array of float
        What is left to the layers, as (s, 1) from (s, 1).
    form : (7, 7, m) array of float
        Symmetric matrix F of each face: the energy per area of the zones is x.F x / 2, x = (s, 1).
    """

    matrix: Array
    form: Array

    def part(self, block: slice) -> "WallZones":
        """Return the zones of some of the faces."""
        return WallZones(self.matrix[:, :, block], self.form[:, :, block])

    def layer_strains(self, s: Array) -> Array:
        """Return the strain and curvature of the layers, (6, m)."""
        return np.einsum("abm,bm->am", self.matrix[:6, :6], s) + self.matrix[:6, 6]

    def energy(self, s: Array) -> Array:
        """Return the energy per area of the zones, J/m2, (m,)."""
        last = np.einsum("am,am->m", self.form[6, :6], s) + self.form[6, 6]
        return np.asarray(0.5 * ((s * self._slope(s)).sum(axis=0) + last))

    def resultants(self, s: Array, of_layers: Array) -> Array:
        """Return the derivative by s of all energy, from that of the layers by theirs, (6, m)."""
        return np.einsum("abm,am->bm", self.matrix[:6, :6], of_layers) + self._slope(s)

    def stiffness(self, of_layers: Array) -> Array:
        """Return the second derivative of all energy, (6, 6, m); see `resultants`."""
        left = self.matrix[:6, :6]
        stiff = np.einsum("abm,bcm->acm", of_layers, left)
        return np.einsum("abm,acm->bcm", left, stiff) + self.form[:6, :6]

    def _slope(self, s: Array) -> Array:
        return np.einsum("abm,bm->am", self.form[:6, :6], s) + self.form[:6, 6]
