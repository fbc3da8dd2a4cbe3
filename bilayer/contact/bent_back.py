"""The pairs of triangles of a skin that are bent back and near: a search in two trees at once.

The triangles are halved again and again into compact groups of the flat body. The search starts at
the coarsest pair of groups. It splits only those pairs whose enclosing balls allow that some of
their triangles are bent back and near enough. On a smooth sheet their number is a few times that of
the triangles, however fine the mesh is.
docs/measures.md has the rule.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

BENT_BACK = 0.5
"""Two places are bent back onto each other when nearer than this share of their natural distance.

An arc of a circle is that short from a turn of 217 degrees on.
"""
BLOCK = 2**18
"""Pairs that are judged at once: some tens of megabytes."""


@dataclass(frozen=True, eq=False)
class Balls:
    """Balls, each around a group of places.

    Parameters
    ----------
    centres : (k, d) array of float
        m.
    radii : (k,) array of float
        m.
    """

    centres: Array
    radii: Array

    def enclose_groups(self, groups: Indices) -> "Balls":
        """Return a ball around those of each group, (k, size)."""
        members = self.centres[groups]
        centres = members.mean(axis=1)
        away = np.linalg.norm(members - centres[:, None], axis=2) + self.radii[groups]
        return Balls(centres, away.max(axis=1))

    def distances(self, pairs: Indices) -> tuple[Array, Array]:
        """Return the least and the largest distance of two places in each pair of balls, m."""
        one, other = np.ascontiguousarray(pairs.T)
        between = self.centres.take(one, axis=0)
        between -= self.centres.take(other, axis=0)
        apart = np.sqrt(np.einsum("ij,ij->i", between, between))
        if not self.radii.any():
            return apart, apart
        size = self.radii.take(one) + self.radii.take(other)
        return np.maximum(0.0, apart - size), apart + size


@dataclass(frozen=True, eq=False)
class Places:
    """Triangles of a skin, or groups of them, by what decides on a pair.

    Parameters
    ----------
    natural : Balls
        The centres of the mesh's triangles in the flat body, shrunk to natural distances.
    chord : Balls
        The same on the released interface.
    skin : Balls
        Around the skin's triangles.
    """

    natural: Balls
    chord: Balls
    skin: Balls

    def grouped(self, groups: Indices) -> "Places":
        """Return the groups, (k, size), as places."""
        return Places(
            *(part.enclose_groups(groups) for part in (self.natural, self.chord, self.skin))
        )

    def may_be_bent_back(self, pairs: Indices, reach: float) -> Indices:
        """Return those pairs of groups of which some places may be bent back and within reach."""
        chord, _ = self.chord.distances(pairs)
        _, natural = self.natural.distances(pairs)
        pairs = pairs[chord < BENT_BACK * natural]  # the least are left of small groups
        skin, _ = self.skin.distances(pairs)
        return pairs[skin <= reach]

    def bound_distance(self, pairs: Indices, apart: float) -> float:
        """Return within what distance some places are that are surely bent back, m.

        Only those count whose natural distance is surely more than `apart`.
        """
        natural, _ = self.natural.distances(pairs)
        pairs, natural = pairs[natural > apart], natural[natural > apart]
        _, chord = self.chord.distances(pairs)
        _, skin = self.skin.distances(pairs[chord < BENT_BACK * natural])
        return float(skin.min(initial=np.inf))


def bent_back_pairs(places: Places, flat: Array, nodes: Indices, reach: float) -> Indices:
    """Return the pairs of triangles that are bent back and may be the nearest ones.

    Neighbours on the mesh, which share a node, are no pair: they always touch.

    Parameters
    ----------
    places : Places
        The skin's triangles, n of them.
    flat : (n, 3) array of float
        Their centres in the flat body, m.
    nodes : (n, 3) array of int
        Corners of the mesh's triangle that each of them covers.
    reach : float
        Distance beyond which none is sought, m.

    Returns
    -------
    (k, 2) array of int
        Those with the smallest distance among them, if that is within reach; one may come twice.
    """
    members = _halve_groups(flat)
    apart = _farthest_neighbours(places.natural.centres, nodes)
    pairs: Indices = np.zeros((1, 2), dtype=np.int64)
    count = 1
    for groups in _levels(members):
        children = np.arange(len(groups)).reshape(count, -1)
        count = len(groups)
        level = places.grouped(groups)
        found: list[Indices] = [np.zeros((0, 2), dtype=np.int64)]
        for block in _split(pairs, children):
            kept = level.may_be_bent_back(block, reach)
            reach = min(reach, level.bound_distance(kept, apart))
            found.append(kept)
        pairs = np.concatenate(found)
    pairs = members.ravel()[pairs]
    one, other = nodes[pairs].swapaxes(0, 1)
    return pairs[~(one[:, :, None] == other[:, None]).any(axis=(1, 2))]


def _halve_groups(points: Array) -> Indices:
    """Return compact groups of two to four points, in the order of the tree that halves made.

    Each half is as large as the other, across the widest extent; a few points come twice for that.
    """
    depth = max(0, len(points).bit_length() - 2)
    order: Indices = np.resize(np.arange(len(points)), (1, 2**depth * -(-len(points) // 2**depth)))
    for _ in range(depth):
        block = points[order]
        widest = np.ptp(block, axis=1).argmax(axis=1)
        along = np.take_along_axis(block, widest[:, None, None], axis=2)[:, :, 0]
        order = np.take_along_axis(order, np.argsort(along, axis=1), axis=1)
        order = order.reshape(2 * len(order), -1)
    return order


def _levels(members: Indices) -> Iterator[Indices]:
    """Yield the groups of the tree from the coarsest to single triangles."""
    count = 1
    while count < len(members):
        yield members.reshape(count, -1)
        count *= 2
    yield members
    yield members.reshape(-1, 1)


def _split(pairs: Indices, children: Indices) -> Iterator[Indices]:
    """Yield the pairs of the children of pairs of groups, each once, in blocks."""
    size = children.shape[1]
    for start in range(0, len(pairs), BLOCK // size**2):
        one, other = children[pairs[start : start + BLOCK // size**2]].swapaxes(0, 1)
        block = np.stack(np.broadcast_arrays(one[:, :, None], other[:, None]), axis=-1)
        block = block.reshape(-1, 2)
        yield block[block[:, 0] <= block[:, 1]]


def _farthest_neighbours(centres: Array, nodes: Indices) -> float:
    """Return a distance that no two triangles which share a node exceed, m."""
    corners = nodes.ravel()
    n = corners.max() + 1
    count = np.maximum(np.bincount(corners, minlength=n), 1)
    thirds = np.repeat(centres, 3, axis=0)
    middle = np.column_stack([np.bincount(corners, part, minlength=n) for part in thirds.T])
    away = np.linalg.norm(thirds - (middle / count[:, None])[corners], axis=1)
    return 2 * float(away.max())
