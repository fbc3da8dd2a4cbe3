"""The self-contact gap of a released body, from the skin of its layers.

Two places of the skin can touch only if the sheet is bent back onto itself. This is measured on the
reference surface, so that a tight curl whose inner side is short does not count as contact.
docs/measures.md has the definition.
"""

import numpy as np
from numpy.typing import NDArray

from bilayer.contact.bent_back import Balls, Places, bent_back_pairs
from bilayer.contact.skin import BondedBody, Skin, skin_of
from bilayer.contact.triangle_distance import triangle_distance
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import flat_surface

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TOUCHING = 1e-6
"""Skins nearer than this share of that thickness touch: above round-off, below every error."""
BATCH = 4096
"""Pairs of triangles that are measured at once."""


def self_contact_gap(body: BondedBody, position: Array) -> float:
    """Return the smallest distance between two places of the skin that are bent back, m.

    Parameters
    ----------
    body : BondedBody
        The flat state.
    position : (n, 3) array of float
        The reference surface on the nodes of its mesh, m.

    Returns
    -------
    float
        0 if the body touches or crosses itself; infinity if no two places that are bent back
        onto each other come nearer than `body.reach`.
    """
    reference = Surface(np.asarray(position, dtype=np.float64), body.mesh.triangles)
    skin = skin_of(body, reference)
    pairs = _bent_back_pairs(body, reference, skin)
    touching = TOUCHING * body.thickness
    nearest = _smallest_distance(skin.surface.corners, pairs, touching, body.reach)
    return 0.0 if nearest <= touching else nearest


def _bent_back_pairs(body: BondedBody, reference: Surface, skin: Skin) -> Indices:
    """Return pairs of the skin's triangles that are bent back, (k, 2), the nearest among them."""
    flat = flat_surface(body.mesh)
    natural, chord = (s.corners.mean(axis=1)[skin.face] for s in (flat, reference))
    corners, points = skin.surface.corners, np.zeros(len(skin.face))
    places = Places(
        Balls(body.shrinkage * natural, points),
        Balls(chord, points),
        Balls(corners.mean(axis=1), _radii(corners)),
    )
    bonded = skin_of(body, flat).surface.corners.mean(axis=1)
    return bent_back_pairs(places, bonded, body.mesh.triangles[skin.face], body.reach)


def _apart(points: Array, one: Indices, other: Indices) -> Array:
    """Return the distance of each two points, m."""
    between = points[one] - points[other]
    return np.sqrt(np.einsum("ij,ij->i", between, between))


def _smallest_distance(corners: Array, pairs: Indices, touching: float, reach: float) -> float:
    """Return the smallest distance of the pairs of triangles; infinity beyond the reach.

    Nearest first by their circles, until no other pair can be nearer than the best, or two touch.
    """
    centres, radii = corners.mean(axis=1), _radii(corners)
    one, other = pairs.T
    at_least = _apart(centres, one, other) - radii[one] - radii[other]
    order = np.argsort(at_least)
    best = float(np.inf)
    for start in range(0, len(order), BATCH):
        batch = order[start : start + BATCH]
        if best <= touching or at_least[batch[0]] > min(best, reach):
            break
        found = triangle_distance(corners[one[batch]], corners[other[batch]]).min()
        best = min(best, float(found))
    return best if best <= reach else float(np.inf)


def _radii(corners: Array) -> Array:
    """Return the distance of each triangle's farthest corner from its centre, m."""
    return np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max(axis=1)
