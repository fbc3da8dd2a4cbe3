"""What can be cut: the least widths of strips and cutouts, as functions of the design.

Along arcs around the origin, at radii from where the cuts begin to the rim.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.designing.mesh_motion import PolarSheet
from bilayer.specimen.specimen import Specimen
from bilayer.validation import keep, not_negative

Array = NDArray[np.float64]

RADII = 13


@dataclass(frozen=True)
class LeastWidths:
    """The least widths that are allowed.

    Parameters
    ----------
    least_web : float
        Of a strip, m.
    least_slot : float
        Of a cutout, m.
    least_radius : float
        Where the cuts begin, m.
    """

    least_web: float = 0.0
    least_slot: float = 0.0
    least_radius: float = 0.0

    def __post_init__(self) -> None:
        keep(self, not_negative, "least_web", "least_slot", "least_radius", unit="m")

    @property
    def are_wanted(self) -> bool:
        """Whether any of them is more than 0."""
        return max(self.least_web, self.least_slot, self.least_radius) > 0

    def margins(self, specimen: Specimen) -> Array:
        """Return how much wider everything is, over the characteristic length.

        Negative where it is narrower; empty without cuts, and of drawn cuts, which stay.
        """
        if not self.are_wanted and not PolarSheet.is_known(specimen):
            return np.empty(0)
        sheet = PolarSheet.of(specimen)
        inner = sheet.inner_radius
        if sheet.cut is None:
            return np.empty(0)
        slots, webs = widths(sheet)
        return np.concatenate(
            [slots.ravel() - self.least_slot, webs.ravel() - self.least_web,
             [inner - self.least_radius]]
        ) / specimen.characteristic_length  # fmt: skip

    def binding(self, specimen: Specimen, tolerance: float = 1e-3) -> list[str]:
        """Return the names of the widths that are at their least."""
        if not self.are_wanted:
            return []
        sheet = PolarSheet.of(specimen)
        if sheet.cut is None:
            return []
        slots, webs = widths(sheet)
        near = tolerance * specimen.characteristic_length
        found = {
            "least_slot": slots.min() - self.least_slot,
            "least_web": webs.min() - self.least_web,
            "least_radius": sheet.inner_radius - self.least_radius,
        }
        return [name for name, margin in found.items() if margin < near and getattr(self, name)]


def widths(sheet: PolarSheet) -> tuple[Array, Array]:
    """Return the widths of the cutouts and of the strips at some radii, m, (r, cuts) each."""
    # on a sheet that is no disc the rim is at different radii: up to the nearest
    around: Array = np.asarray(np.linspace(0, 2 * np.pi, 181)[:-1])
    rim = float(sheet.reach(around).min())
    radius: Array = np.asarray(np.linspace(sheet.inner_radius, rim, RADII))
    edges = sheet.edge_angles(radius)
    after = np.roll(edges[:, ::2], -1, axis=1)
    after[:, -1] += 2 * np.pi
    slots = (edges[:, 1::2] - edges[:, ::2]) * radius[:, None]
    return slots, (after - edges[:, 1::2]) * radius[:, None]
