"""The contact barrier: an energy that keeps two places of a skin apart, without friction.

Incremental potential contact (Li et al., ACM Trans. Graph. 39, 2020) by the package ipctk. Each
pair of a point and a triangle, or of two edges, that is nearer than the range d^ has the energy

    area . stiffness . d^ . b(d),      b -> infinity as d -> 0,

b smooth, and 0 from d^ on. The areas are those of the flat skin (Li et al., Convergent IPC, 2023),
so the stiffness is a pressure and the energy has a limit as the mesh is refined. Pairs of one fibre
or of two neighbours never count: they always touch.

ipctk finds the pairs. Those that may come within range are kept until a point has moved by as much
as was allowed for.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from bilayer.contact.package import require_contact
from bilayer.contact.skin_map import SkinMap
from bilayer.geometry.surface import directed_edges

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

RANGE_SHARE_OF_FLAT = 0.5
"""Largest range, over the smallest distance of two places of the flat skin that may touch."""
SLACK = 1.0
"""Motion for which pairs are kept, over the range."""
LONGEST_PART = 25.0
"""Motion that is looked at in one go, over the range: places that move far sweep so much room that
most others are in their way."""
MOST_PARTS = 400
"""Of one motion: those of a step that makes no sense may be kilometres long."""
CLEARANCE = 0.25
"""Motion that is allowed for when the skin is found clear of itself, over the range."""


class Barrier:
    """The barrier between the places of one skin.

    Parameters
    ----------
    triangles : (t, 3) array of int
        The closed skin by its points.
    flat_points : (k, 3) array of float
        The points of the flat skin, m: their areas are the weights.
    fibre : (k,) array of int
        The fibre of each point.
    neighbours : (p, 2) array of int
        Pairs of fibres that are neighbours.
    range : float
        Distance from which on nothing acts, m; less if the flat skin asks for it.
    stiffness : float
        A pressure of the order of those that the body bears, Pa.

    Raises
    ------
    ComputationError
        ipctk is not installed.
    """

    def __init__(
        self,
        triangles: Indices,
        flat_points: Array,
        fibre: Indices,
        neighbours: Indices,
        *,
        range: float,
        stiffness: float,
    ) -> None:
        self._ipctk = require_contact()
        faces = np.asfortranarray(triangles, dtype=np.int32)
        edges = np.asfortranarray(self._ipctk.edges(faces))
        flat = np.asfortranarray(flat_points)
        self._mesh = self._ipctk.CollisionMesh(flat, edges, faces)
        self._fibre, self._beside = fibre, _same_or_beside(fibre, neighbours)
        self._mesh.can_collide = self._ipctk.make_sparse_filter(
            dict.fromkeys(_point_pairs(fibre, self._beside), False), True
        )
        self.range = min(range, RANGE_SHARE_OF_FLAT * self._smallest_distance(flat, range))
        self.stiffness = stiffness
        self._potential = self._ipctk.BarrierPotential(self.range, stiffness, True)
        self._kept: tuple[Array, Any] | None = None
        self._clear: tuple[Array, float] | None = None
        self._stepwise = self._ipctk.AdditiveCCD()

    @classmethod
    def of(cls, skin: SkinMap, flat_nodes: Array, *, range: float, stiffness: float) -> "Barrier":
        """Return the barrier of the skin over a flat surface, (n, 3), m."""
        neighbours = np.unique(np.sort(directed_edges(skin.mesh_triangles), axis=1), axis=0)
        flat = skin.points(flat_nodes)
        return cls(skin.triangles, flat, skin.node, neighbours, range=range, stiffness=stiffness)

    def at(self, points: Array) -> "BarrierState":
        """Return the barrier with the skin's points at (k, 3), m."""
        pairs = () if self._is_clear(points) else self._pairs(points)
        return BarrierState(self._ipctk, self._mesh, self._potential, pairs, points)

    def is_crossed(self, points: Array) -> bool:
        """Whether the skin passes through itself, away from one fibre and its neighbours.

        ipctk also looks at an edge and a triangle of which some, not all, points are neighbours,
        as in a fold sharper than the thickness. Such pairs are left out.
        """
        vertices = np.asfortranarray(points)
        if self._is_clear(points) or not self._ipctk.has_intersections(self._mesh, vertices):
            return False
        pierces = self._ipctk.is_edge_intersecting_triangle
        return any(
            pierces(*points[edge], *points[triangle])
            for edge, triangle in self._edges_near_triangles(vertices)
        )

    def _edges_near_triangles(self, vertices: Array) -> list[tuple[Indices, Indices]]:
        """Return edges and triangles whose boxes overlap, without those of neighbours."""
        edges, faces = self._mesh.edges, self._mesh.faces
        search = self._ipctk.LBVH()
        search.can_vertices_collide = self._mesh.can_collide
        search.build(vertices, edges, faces)
        found = search.detect_edge_face_candidates()
        one = edges[[pair.edge_id for pair in found]]
        other = faces[[pair.face_id for pair in found]]
        places = np.broadcast_arrays(self._fibre[one][:, :, None], self._fibre[other][:, None])
        beside = np.asarray(self._beside[places[0].reshape(-1), places[1].reshape(-1)])
        apart = ~beside.reshape(len(found), -1).any(axis=1)
        return list(zip(one[apart], other[apart], strict=True))

    def free_share(self, start: Array, end: Array) -> float:
        """Return the share of straight ways from start to end until two places touch."""
        if self._is_clear(start) and self._is_clear(end):
            return 1.0
        for before, after, begin, stop in self._parts(start, end):
            share = self._ipctk.compute_collision_free_stepsize(
                self._mesh, np.asfortranarray(begin), np.asfortranarray(stop)
            )
            if share < 1:
                return before + float(share) * (after - before)
        return 1.0

    def stays_clear(self, start: Array, end: Array) -> bool:
        """Whether no two places come within range on straight ways from start to end."""
        return all(self._part_stays_clear(*ends) for _, _, *ends in self._parts(start, end))

    def _parts(self, start: Array, end: Array) -> Iterator[tuple[float, float, Array, Array]]:
        """Yield the parts of straight ways: the shares where they begin and stop, and both ends.

        None is longer than allowed, unless there would be too many of them.
        """
        longest = np.sqrt(((end - start) ** 2).sum(axis=1).max())
        parts = longest / (LONGEST_PART * self.range)
        count = max(1, math.ceil(parts)) if parts < MOST_PARTS else MOST_PARTS
        shares = np.linspace(0, 1, count + 1)
        between = ((1 - share) * start + share * end for share in shares[1:-1])
        ways = itertools.pairwise(itertools.chain([start], between, [end]))
        for share, (begin, stop) in zip(itertools.pairwise(shares), ways, strict=True):
            yield float(share[0]), float(share[1]), begin, stop

    def _part_stays_clear(self, start: Array, end: Array) -> bool:
        if self._is_clear(start) and self._is_clear(end):
            return True
        ends = np.asfortranarray(start), np.asfortranarray(end)
        for clearance in (CLEARANCE * self.range, 0.0):
            apart = self.range + 2 * clearance
            if self._ipctk.is_step_collision_free(
                self._mesh, *ends, apart, narrow_phase_ccd=self._stepwise
            ):
                self._clear = end, clearance
                return True
        return False

    def _is_clear(self, points: Array) -> bool:
        """Whether the points have hardly moved since nothing was within range, by far."""
        if self._clear is None:
            return False
        place, clearance = self._clear
        return bool(((points - place) ** 2).sum(axis=1).max() <= clearance**2)

    def _pairs(self, points: Array) -> Any:
        """Return the pairs within range."""
        vertices = np.asfortranarray(points)
        slack = SLACK * self.range
        if self._kept is None or np.abs(points - self._kept[0]).max() * 3**0.5 > slack:
            candidates = self._ipctk.Candidates()
            candidates.build(self._mesh, vertices, self.range / 2 + slack)
            self._kept = points, candidates
        return self._collisions(self._kept[1], vertices, self.range)

    def _collisions(self, candidates: Any, vertices: Array, range: float) -> Any:
        pairs = self._ipctk.NormalCollisions()
        pairs.use_area_weighting = True
        pairs.collision_set_type = self._ipctk.NormalCollisions.IMPROVED_MAX_APPROX
        pairs.build(candidates, self._mesh, vertices, range)
        return pairs

    def _smallest_distance(self, vertices: Array, range: float) -> float:
        """Return the smallest distance of the flat skin, or infinity beyond twice the range."""
        within = range / RANGE_SHARE_OF_FLAT
        candidates = self._ipctk.Candidates()
        candidates.build(self._mesh, vertices, within / 2)
        pairs = self._collisions(candidates, vertices, within)
        return float(pairs.compute_minimum_distance(self._mesh, vertices)) ** 0.5


@dataclass(frozen=True, eq=False)
class BarrierState:
    """The barrier in one state of the skin; `Barrier.at` makes it."""

    _ipctk: Any
    _mesh: Any
    _potential: Any
    _pairs: Any
    points: Array

    @property
    def pairs(self) -> int:
        """Number of pairs within range."""
        return len(self._pairs)

    @cached_property
    def smallest_gap(self) -> float:
        """Smallest distance of a pair within range, m; infinity if there is none."""
        if not self.pairs:
            return float(np.inf)
        return float(self._pairs.compute_minimum_distance(self._mesh, self._vertices)) ** 0.5

    @property
    def force(self) -> float:
        """Sum of the forces with which places press on each other, N."""
        return float(np.linalg.norm(self.gradient, axis=1).sum()) / 2

    @cached_property
    def energy(self) -> float:
        """J."""
        if not self.pairs:
            return 0.0
        return float(self._potential(self._pairs, self._mesh, self._vertices))

    @cached_property
    def gradient(self) -> Array:
        """Derivative of the energy by the points, N, (k, 3)."""
        if not self.pairs:
            return np.zeros_like(self.points)
        gradient = self._potential.gradient(self._pairs, self._mesh, self._vertices)
        return np.asarray(gradient).reshape(-1, 3)

    def hessian(self) -> csr_matrix:
        """Return the second derivative, N/m, (3 k, 3 k)."""
        return self._hessian(self._ipctk.PSDProjectionMethod.NONE)

    def convex_hessian(self) -> csr_matrix:
        """Return the same with the negative eigenvalues of each pair set to 0."""
        return self._hessian(self._ipctk.PSDProjectionMethod.CLAMP)

    def _hessian(self, projection: Any) -> csr_matrix:
        found = self._potential.hessian(self._pairs, self._mesh, self._vertices, projection)
        return csr_matrix(found)

    @cached_property
    def _vertices(self) -> Array:
        return np.asfortranarray(self.points)


def _same_or_beside(fibre: Indices, neighbours: Indices) -> csr_matrix:
    """Return for all pairs of fibres whether they are one or neighbours, (f, f)."""
    count = int(fibre.max(initial=-1)) + 1
    itself = np.arange(count)
    one = np.concatenate([itself, *neighbours.T])
    other = np.concatenate([itself, *neighbours.T[::-1]])
    return csr_matrix((np.ones(len(one), dtype=bool), (one, other)), shape=(count, count))


def _point_pairs(fibre: Indices, beside: csr_matrix) -> list[tuple[int, int]]:
    """Return the pairs of points i < j that lie on one fibre or on neighbours."""
    places = (np.arange(len(fibre)), fibre)
    on_fibre = csr_matrix((np.ones(len(fibre)), places), shape=(len(fibre), beside.shape[0]))
    one, other = (on_fibre @ beside.astype(float) @ on_fibre.T).nonzero()
    return [(int(i), int(j)) for i, j in zip(one, other, strict=True) if i < j]
