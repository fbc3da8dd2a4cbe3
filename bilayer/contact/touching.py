"""How a body touches itself: forces, pressures and gap of the barrier in one state."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bilayer.contact.several import SkinBarrier, SkinBarrierState
from bilayer.geometry.surface import Surface

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class Covering(Protocol):
    """A skin, and what of the planar mesh lies under it."""

    @property
    def mesh_triangles(self) -> Indices:
        """The planar mesh, (m, 3)."""

    @property
    def triangles(self) -> Indices:
        """The skin by its points, (t, 3)."""

    @property
    def face(self) -> Indices:
        """The mesh's triangle that each of them covers, (t,)."""


@dataclass(frozen=True, eq=False)
class Touching:
    """The contact of a body with itself at one milestone.

    Parameters
    ----------
    gap : float
        Smallest distance of two places of the skin, m; infinity beyond the range of the barrier.
    force : float
        Sum of the forces with which its places press on each other and on obstacles, N.
    pressure : (m,) array of float
        Pressure on the skin of each of the mesh's triangles, Pa.
    energy : float
        Of the barrier, J.
    pairs : int
        Pairs of places within range.
    crosses : bool
        Whether the skin passes through itself all the same.
    """

    gap: float
    force: float
    pressure: Array
    energy: float
    pairs: int
    crosses: bool


def measure_touching(skin: Covering, barrier: SkinBarrier, state: SkinBarrierState) -> Touching:
    """Return how a body touches itself.

    Each point's force is shared by the skin's triangles around it as their areas are.

    Parameters
    ----------
    skin, barrier
        The skin, and what keeps its places apart.
    state : SkinBarrierState
        The barrier where the body is.
    """
    forces = np.linalg.norm(state.gradient, axis=1)
    surface = Surface(state.points, skin.triangles)
    per_area = np.divide(
        forces, surface.node_areas, out=np.zeros_like(forces), where=surface.node_areas > 0
    )
    on_triangles = surface.areas * per_area[skin.triangles].mean(axis=1)
    faces = len(skin.mesh_triangles)
    areas = np.bincount(skin.face, surface.areas, minlength=faces)
    pressure = np.bincount(skin.face, on_triangles, minlength=faces) / areas
    return Touching(
        state.smallest_gap,
        state.force,
        pressure,
        state.energy,
        state.pairs,
        barrier.is_crossed(state.points),
    )
