"""The planar mesh of a specimen, made by gmsh with the cut edges in it.

The disc is drawn as its kirigami part and its cutouts, sharing the cut edges; the centre is a
node, because it is the one that the paper's method holds.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import psutil
from numpy.typing import NDArray

from bilayer.errors import ComputationError, InputError
from bilayer.mesh.layering import check_layering
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.outline import Disc
from bilayer.specimen.pattern import CutPattern
from bilayer.specimen.specimen import Specimen

BYTES_PER_TRIANGLE = 2000
"""Memory that gmsh and the arrays of the mesh take (measured: 1.3 to 1.9 kB per triangle)."""


TRIANGLES_PER_AREA = 1.2 * 4 / math.sqrt(3)
"""Times the square of the mesh size: 1.2 (measured) times as many as equilateral ones."""


def size_for(triangles: int, radius: float) -> float:
    """Return the mesh size that gives a disc about so many triangles, m."""
    return radius * math.sqrt(math.pi * TRIANGLES_PER_AREA / triangles)


def estimated_triangles(specimen: Specimen) -> float:
    """Return the number of triangles to expect.

    Their size goes linearly from the corners' at the inner radius to the mesh's at the rim. Strips
    and cutouts narrower than that are a row of two triangles for every length of it.
    """
    radius, cut = _sector_disc(specimen)
    size = specimen.mesh.size
    finest, inner = size, 0.0
    if cut is not None and specimen.mesh.corner_size is not None:
        finest, inner = specimen.mesh.corner_size, cut.inner_radius
    rings = 10_000
    r = (np.arange(rings) + 0.5) * radius / rings
    with np.errstate(over="ignore", divide="ignore"):
        local_size = np.interp(r, [0.0, inner, radius], [size, finest, size])
        per_area = TRIANGLES_PER_AREA / local_size**2
        sectors, angle = _sectors(cut, r)
        in_each = np.maximum(per_area * angle * r, 2 / local_size)
        return float(np.sum(sectors * in_each) * radius / rings)


def _sector_disc(specimen: Specimen) -> tuple[float, CutPattern | None]:
    """Return the radius and the sectors of a disc whose layers are whole or cut by the same ones.

    Raises
    ------
    InputError
        It is not such a disc.
    """
    cuts = {layer.pattern for layer in specimen.layers} - {None}
    if not isinstance(specimen.outline, Disc) or len(cuts) > 1:
        raise InputError("outline: expected a disc with one pattern of sectors")
    cut = next(iter(cuts), None)
    if cut is not None and not isinstance(cut, CutPattern):
        raise InputError(f"pattern = {cut!r}: expected sectors")
    return specimen.outline.radius, cut


def _sectors(cut: CutPattern | None, r: NDArray[np.float64]) -> tuple[Any, NDArray[np.float64]]:
    """Return how many sectors there are, and their angle: the whole disc, or strips and cutouts."""
    if cut is None:
        return 1, np.full_like(r, 2 * math.pi)
    strip = 2 * math.pi / cut.strips - cut.cutout_angle
    angles = np.array([[strip], [cut.cutout_angle]])
    inside = r < cut.inner_radius
    return np.where(inside, 0.5, cut.strips), np.where(inside, 2 * math.pi, angles)


def check_memory(specimen: Specimen, bytes_per_triangle: float, what: str) -> None:
    """Raise InputError where the mesh size asks for more memory than there is.

    Parameters
    ----------
    specimen : Specimen
        Its radius and mesh size tell the number of triangles.
    bytes_per_triangle : float
        What the step named `what` takes.
    what : str
        For the message: "the mesh", "the finite-element model", ...
    """
    count = estimated_triangles(specimen)
    _check_available(
        f"mesh.size = {specimen.mesh.size} m: about {count:.3g}", count * bytes_per_triangle, what
    )


def mesh_within_memory(
    specimen: Specimen, mesh: PlanarMesh | None, bytes_per_triangle: float, what: str
) -> PlanarMesh:
    """Return a given mesh, or that of a specimen, if there is the memory to go on with it.

    Parameters
    ----------
    specimen : Specimen
        To be meshed where there is no mesh.
    mesh : PlanarMesh or None
        The mesh that is given.
    bytes_per_triangle, what
        See `check_memory`.

    Raises
    ------
    InputError
        There is less memory than needed, or the layers do not lie on each other everywhere.
    ComputationError
        gmsh is not there, or fails.
    """
    if mesh is None:
        check_memory(specimen, bytes_per_triangle, what)
        mesh = generate_mesh(specimen)
    else:
        count = len(mesh.triangles)
        _check_available(f"mesh: its {count}", count * bytes_per_triangle, what)
    check_layering(specimen, mesh)
    return mesh


def _check_available(triangles: str, needed: float, what: str) -> None:
    available = psutil.virtual_memory().available
    if needed > available:
        raise InputError(
            f"{triangles} triangles would take {needed / 2**30:.3g} GiB for {what}, expected at "
            f"most the {available / 2**30:.3g} GiB of memory available"
        )


def generate_mesh(specimen: Specimen) -> PlanarMesh:
    """Mesh the bonded flat disc of a specimen.

    Parameters
    ----------
    specimen : Specimen
        Outer radius, cut pattern and mesh sizes.

    Returns
    -------
    PlanarMesh
        With the layers that lie on each triangle; the cut edges are edges of the mesh.

    Raises
    ------
    InputError
        The mesh would not fit into memory.
    ComputationError
        gmsh is not there, or fails.
    """
    check_memory(specimen, BYTES_PER_TRIANGLE, "the mesh")
    with gmsh_session() as gmsh:
        try:
            covered, bare = _draw(gmsh, specimen)
            gmsh.model.mesh.generate(2)
            triangles = [_triangles(gmsh, covered), _triangles(gmsh, bare)]
            tags, coordinates, _ = gmsh.model.mesh.getNodes()
        except Exception as error:  # gmsh raises bare Exceptions
            raise ComputationError(f"gmsh could not mesh the specimen: {error}") from error
    return _numbered_from_zero(specimen, tags, coordinates, triangles)


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """Give gmsh, quiet and with an empty model, and leave it as it was found."""
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise ComputationError(
            f"gmsh cannot be loaded ({error}): install the package gmsh with the system libraries "
            "that it names (on Debian: apt install python3-gmsh), or give a mesh file"
        ) from error
    started_here = not gmsh.isInitialized()
    if started_here:
        gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)  # the same mesh at every run
        gmsh.option.setNumber("Mesh.Algorithm", 6)  # frontal Delaunay: near-equilateral triangles
        gmsh.model.add("bilayer")
        yield gmsh
    finally:
        gmsh.model.remove()
        if started_here:
            gmsh.finalize()


class _Cutout(NamedTuple):
    """What the drawing of the strips needs to know of a drawn cutout."""

    surface: int
    cut_edges: list[int]
    rim_start: int
    rim_end: int
    first_angle: float
    last_angle: float


def _draw(gmsh: Any, specimen: Specimen) -> tuple[list[int], list[int]]:
    """Draw the disc; return the surface where all layers lie and the bare ones."""
    geo = gmsh.model.geo
    radius, cut = _sector_disc(specimen)
    centre = geo.addPoint(0, 0, 0, specimen.mesh.size)
    pen = _Pen(geo, centre)
    if cut is None:
        start = pen.point(radius, 0.0, specimen.mesh.size)
        rim = (radius, specimen.mesh.size)
        outline = pen.arcs(start, start, 0.0, 2 * math.pi, *rim)
        bare: list[int] = []
    else:
        outline, bare = _draw_cuts(pen, specimen, cut)
    disc = geo.addPlaneSurface([geo.addCurveLoop(outline)])
    geo.synchronize()
    gmsh.model.mesh.embed(0, [centre], 2, disc)
    return [disc], bare


def _draw_cuts(pen: "_Pen", specimen: Specimen, cut: CutPattern) -> tuple[list[int], list[int]]:
    """Draw the cutouts; return the outline of the kirigami part and the cutouts' surfaces."""
    cutouts = [_draw_cutout(pen, specimen, cut, middle) for middle in cut.cutout_centres]
    outline: list[int] = []
    for here, following in zip(cutouts, [*cutouts[1:], cutouts[0]], strict=True):
        end_angle = following.first_angle
        if end_angle <= here.last_angle:
            end_angle += 2 * math.pi
        strip_rim = pen.arcs(
            here.rim_end, following.rim_start, here.last_angle, end_angle,
            specimen.characteristic_length, specimen.mesh.size,
        )  # fmt: skip
        outline += [*here.cut_edges, *strip_rim]
    return outline, [cutout.surface for cutout in cutouts]


def _draw_cutout(pen: "_Pen", specimen: Specimen, cut: CutPattern, middle: float) -> _Cutout:
    """Draw one cutout, bounded by two radial cuts, an inner arc and a piece of the rim."""
    size, corner_size = specimen.mesh.size, specimen.mesh.corner_size or specimen.mesh.size
    first, last = middle - cut.cutout_angle / 2, middle + cut.cutout_angle / 2
    corner_1 = pen.point(cut.inner_radius, first, corner_size)
    corner_2 = pen.point(cut.inner_radius, last, corner_size)
    rim_1 = pen.point(specimen.characteristic_length, first, size)
    rim_2 = pen.point(specimen.characteristic_length, last, size)
    inward, outward = pen.geo.addLine(rim_1, corner_1), pen.geo.addLine(corner_2, rim_2)
    inner_arcs = pen.arcs(corner_1, corner_2, first, last, cut.inner_radius, corner_size)
    rim_arcs = pen.arcs(rim_1, rim_2, first, last, specimen.characteristic_length, size)
    loop = [*rim_arcs, -outward, *[-arc for arc in reversed(inner_arcs)], -inward]
    surface = pen.geo.addPlaneSurface([pen.geo.addCurveLoop(loop)])
    return _Cutout(surface, [inward, *inner_arcs, outward], rim_1, rim_2, first, last)


class _Pen(NamedTuple):
    """Points and arcs around the centre, in gmsh's built-in geometry."""

    geo: Any
    centre: int

    def point(self, radius: float, angle: float, size: float) -> int:
        return self.geo.addPoint(radius * math.cos(angle), radius * math.sin(angle), 0, size)

    def arcs(
        self, start: int, end: int, first: float, last: float, radius: float, size: float
    ) -> list[int]:
        """Return the arc from `start` to `end`, in pieces: gmsh's are of less than half a turn."""
        pieces = math.ceil((last - first) / (2 * math.pi / 3) - 1e-9)
        angles = [first + (last - first) * k / pieces for k in range(1, pieces)]
        points = [start, *(self.point(radius, angle, size) for angle in angles), end]
        return [self.geo.addCircleArc(a, self.centre, b) for a, b in pairwise(points)]


def _triangles(gmsh: Any, surfaces: list[int]) -> NDArray[np.int64]:
    """Node tags of the triangles of some surfaces, counterclockwise, shape (m, 3)."""
    parts = [gmsh.model.mesh.getElementsByType(2, surface)[1] for surface in surfaces]
    return np.concatenate([np.empty(0), *parts]).astype(np.int64).reshape(-1, 3)


def _numbered_from_zero(
    specimen: Specimen,
    tags: NDArray[Any],
    coordinates: NDArray[Any],
    triangles: list[NDArray[np.int64]],
) -> PlanarMesh:
    sets = specimen.layer_sets
    covered = sets.index(frozenset(specimen.layer_names))
    bare = sets.index(frozenset(layer.name for layer in specimen.layers if layer.is_whole))
    region = np.repeat([covered, bare], [len(part) for part in triangles])
    used, renumbered = np.unique(np.concatenate(triangles), return_inverse=True)
    order = np.argsort(tags)
    rows = order[np.searchsorted(tags[order], used)]
    points = coordinates.reshape(-1, 3)[rows, :2]
    return PlanarMesh(points, renumbered.reshape(-1, 3), region, sets)
