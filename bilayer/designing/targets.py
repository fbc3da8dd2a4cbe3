"""Target shapes: by formula, from a map of heights, from a mesh. All are triangulated surfaces.

A shape by formula is drawn over a disc or a square that is filled evenly. Its axes are such that it
opens downward, as a dome does, along -z.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from bilayer.errors import InputError
from bilayer.geometry.surface import Surface
from bilayer.mesh.files import read_mesh_file
from bilayer.runtime.input_file import read_text
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.units import in_si
from bilayer.validation import finite, one_of, positive, text, within

Array = NDArray[np.float64]

NODES = 800
"""Of a shape by formula: its facets are then within 0.15 % of the radius of a hemisphere."""
LARGEST = 1e3
"""Of a coordinate, m."""
SMALLEST_AREA = 1e-9
"""Of a target, over the square of its extent."""
LONGEST_SIDE = 2.0
"""Of a triangle between points of a height map, over the usual distance of neighbours."""
MOST_LARGER = 20.0
"""Size of a target over that of the sheet, or the other way round: beyond, a unit is wrong."""
MESHES = (".stl", ".ply", ".obj", ".off")
TABLES = (".csv", ".xyz", ".txt")
SIZES = ("fixed", "free")
LENGTHS = {
    "radius": "m", "angle": "rad", "width": "m", "depth": "m", "height": "m", "outer_radius": "m",
    "curvature": "1/m",
}  # fmt: skip
LENGTH_UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2}


@dataclass(frozen=True, eq=False)
class Target:
    """A shape that a design shall take.

    Parameters
    ----------
    surface : Surface
        The shape, m.
    words : str
        Description for a report.
    is_size_free : bool
        Whether it may be larger or smaller.
    """

    surface: Surface
    words: str
    is_size_free: bool = False

    @property
    def identity(self) -> str:
        """A text that two targets share if they are the same."""
        held = self.surface.points.tobytes() + self.surface.triangles.tobytes()
        return f"{sha256(held).hexdigest()} {self.is_size_free}"

    @property
    def diagonal(self) -> float:
        """Diagonal of the bounding box, m."""
        return float(np.linalg.norm(np.ptp(self.surface.points, axis=0)))


def target_from_table(table: Mapping[str, Any], folder: Path, specimen: Specimen) -> Target:
    """Return the target of a design file's table [target].

    Parameters
    ----------
    table : mapping
        Either `shape` with the lengths of its formula, or `file` and `unit`; `size` as well.
    folder : Path
        Where the file lies.
    specimen : Specimen
        Whose meridian a hemisphere or cap has if no radius is given.
    """
    given = in_si("target", table, LENGTHS)
    size = one_of("target.size", given.pop("size", "fixed"), SIZES)
    if "file" in given:
        name = text("target.file", given.pop("file"))
        unit = given.pop("unit", "mm")
        if given:
            raise InputError(f"target.{next(iter(given))}: not together with target.file")
        return _of_this_size(Target(read_target(folder / name, unit),
                                    f"the shape of {Path(name).name}", size == "free"),
                             specimen)  # fmt: skip
    shape = one_of("target.shape", given.pop("shape", None), FORMULAS)
    given = {name: finite(f"target.{name}", value) for name, value in given.items()}
    if shape in ("hemisphere", "cap") and "radius" not in given:
        angle = given.get("angle", math.pi / 2)
        given["radius"] = specimen.characteristic_length / angle
    numbers = ", ".join(f"{name} {value:.6g} {LENGTHS.get(name, '')}".strip()
                        for name, value in given.items())  # fmt: skip
    words = f"{shape}" + (f" ({numbers})" if numbers else "")
    return _of_this_size(Target(formula(shape, **given), words, size == "free"), specimen)


def _of_this_size(target: Target, specimen: Specimen) -> Target:
    """Return a target; InputError if it is far larger or smaller than the sheet."""
    sheet = 2 * specimen.characteristic_length
    if not sheet / MOST_LARGER < target.diagonal < MOST_LARGER * sheet:
        raise InputError(
            f"target: {target.words} is {target.diagonal:.3g} m from corner to corner and the "
            f"sheet {sheet:.3g} m across, expected less than {MOST_LARGER:g} times between them; "
            "a bare number is in m, a file in mm unless target.unit says so"
        )
    return target


def cap(radius: float, angle: float = math.pi / 2) -> Surface:
    """Return a spherical cap.

    Parameters
    ----------
    radius : float
        Of the sphere, m.
    angle : float
        From the axis to the rim, rad; pi / 2: a hemisphere.

    Examples
    --------
    >>> float(cap(0.025).points[:, 2].max().round(4))
    0.025
    """
    radius, angle = positive("radius", radius, "m"), within("angle", angle, 1e-3, math.pi - 1e-3)
    across = _disc()
    r = np.hypot(*across.points.T[:2])
    # equal areas of the disc are equal areas of the sphere (Lambert)
    cosine = 1 - r**2 * (1 - math.cos(angle))
    sine = np.sqrt(np.maximum(1 - cosine**2, 0))
    flat = across.points[:, :2] / np.where(r > 0, r, 1.0)[:, None]
    return Surface(radius * np.column_stack([sine[:, None] * flat, cosine]), across.triangles)


def ellipsoid(width: float, depth: float, height: float) -> Surface:
    """Return half an ellipsoid with these semi-axes along x, y and z, m."""
    half = cap(1.0)
    axes = [positive(n, v, "m") for n, v in zip(("width", "depth", "height"),
                                               (width, depth, height), strict=True)]  # fmt: skip
    return Surface(half.points * axes, half.triangles)


def saddle(radius: float, curvature: float) -> Surface:
    """Return the saddle z = curvature (x^2 - y^2) / 2 over a disc, m, curvature in 1/m."""
    radius, curvature = positive("radius", radius, "m"), positive("curvature", curvature, "1/m")
    disc = _disc()
    x, y, _ = radius * disc.points.T
    return Surface(np.column_stack([x, y, curvature * (x**2 - y**2) / 2]), disc.triangles)


def cylinder(radius: float, outer_radius: float) -> Surface:
    """Return a disc rolled onto a cylinder about the y axis, m."""
    radius, outer = positive("radius", radius, "m"), positive("outer_radius", outer_radius, "m")
    disc = _disc()
    x, y, _ = outer * disc.points.T
    at = x / radius
    return Surface(np.column_stack([radius * np.sin(at), y, radius * np.cos(at)]), disc.triangles)


FORMULAS: dict[str, Callable[..., Surface]] = {
    "hemisphere": cap,
    "cap": cap,
    "ellipsoid": ellipsoid,
    "saddle": saddle,
    "cylinder": cylinder,
}
"""By the name of the shape in a design file."""


def formula(shape: str, **lengths: float) -> Surface:
    """Return a target by the name of its formula.

    Raises
    ------
    InputError
        There is no such formula, or a number of it is missing, too many, or out of its range.
    """
    make = FORMULAS[one_of("target.shape", shape, FORMULAS)]
    try:
        return make(**lengths)
    except TypeError as error:
        words = str(error).split("() ", 1)[-1]
        raise InputError(f"target: a {shape} {words}") from None


def read_target(path: str | Path, unit: str = "mm") -> Surface:
    """Return the surface of a file: a mesh (STL, PLY, OBJ, OFF) or heights x, y, z (CSV, XYZ).

    Raises
    ------
    InputError
        It cannot be read, or holds no surface.
    """
    source = Path(path)
    factor = LENGTH_UNITS[one_of("target.unit", unit, LENGTH_UNITS)]
    if source.suffix.lower() in TABLES:
        return height_map(factor * _numbers(source))
    if source.suffix.lower() not in MESHES:
        names = ", ".join((*MESHES, *TABLES))
        raise InputError(f"target.file = {str(path)!r}: expected a name in {names}")
    mesh, _ = read_mesh_file(source)
    triangles = np.asarray(mesh.get_cells_type("triangle"), dtype=np.int64)
    if len(triangles) == 0:
        raise InputError(f"target.file = {str(path)!r}: has no triangles")
    if not 0 <= triangles.min() <= triangles.max() < len(mesh.points):
        raise InputError(
            f"target.file = {str(path)!r}: a triangle has the point {triangles.max()}, expected "
            f"one of {len(mesh.points)}"
        )
    points, merged = np.unique(factor * mesh.points, axis=0, return_inverse=True)
    return _with_area(Surface(points, merged.reshape(-1)[triangles]))


def _with_area(surface: Surface) -> Surface:
    """Return a surface; InputError if its points are no numbers, or it has no area."""
    points = surface.points
    if not np.isfinite(points).all() or np.abs(points).max(initial=0) > LARGEST:
        raise InputError(f"target: has points beyond {LARGEST:g} m or that are no numbers")
    if surface.areas.sum() <= SMALLEST_AREA * np.ptp(points, axis=0).max(initial=0.0) ** 2:
        raise InputError("target: its points lie on a line or in one point, expected a surface")
    return surface


def height_map(points: Array) -> Surface:
    """Return the surface through points (x, y, z), one above each place of a plane, m, (n, 3).

    Places that lie apart by more than the usual distance of neighbours are not joined.
    """
    if len(points) < 4 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise InputError(f"target: has {len(points)} points, expected at least 4 of x, y and z")
    from_middle = points[:, :2] - points[:, :2].mean(axis=0)
    across, along = np.sort(np.linalg.svd(from_middle, compute_uv=False))
    if along > LARGEST * len(points) or across <= SMALLEST_AREA * along:
        raise InputError(
            "target: its points lie on a line, in one place or beyond all lengths, expected a "
            "height z above each place (x, y)"
        )
    triangles = Delaunay(points[:, :2]).simplices
    flat = points[triangles][:, :, :2]
    sides = np.linalg.norm(flat - np.roll(flat, 1, axis=1), axis=2)
    shortest = np.median(sides.min(axis=1))
    near = sides.max(axis=1) < LONGEST_SIDE * shortest
    return Surface(points, _counterclockwise(points, triangles[near].astype(np.int64)))


def _counterclockwise(points: Array, triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return triangles that are seen counterclockwise from above."""
    down = Surface(points, triangles).area_vectors[:, 2] < 0
    turned = triangles.copy()
    turned[down] = turned[down][:, [0, 2, 1]]
    return turned


def _disc() -> Surface:
    """Return the unit disc: a Fibonacci lattice, and its rim."""
    inside = np.arange(NODES)
    around = inside * math.pi * (3 - math.sqrt(5))
    apart = math.sqrt(math.pi / NODES)
    radius = (1 - apart / 2) * np.sqrt((inside + 0.5) / NODES)
    rim = np.arange(round(2 * math.pi / apart)) * apart
    points = np.concatenate([
        radius[:, None] * np.column_stack([np.cos(around), np.sin(around)]),
        np.column_stack([np.cos(rim), np.sin(rim)]),
    ])  # fmt: skip
    flat = np.column_stack([points, np.zeros(len(points))])
    return Surface(flat, _counterclockwise(flat, Delaunay(points).simplices.astype(np.int64)))


def _numbers(path: Path) -> Array:
    """Return the first three columns of a table of numbers, (n, 3)."""
    lines = read_text(path, "target").splitlines()
    rows = [line.replace(";", " ").replace(",", " ").split() for line in lines]
    rows = [row for row in rows if row and not row[0].startswith("#")]
    if rows and any(character.isalpha() for character in rows[0][0]):
        rows = rows[1:]
    try:
        table = np.array([[float(value) for value in row[:3]] for row in rows])
    except ValueError as error:
        raise InputError(f"target {path}: expected x, y and z on each line ({error})") from error
    if table.ndim != 2 or table.shape[1] != 3:
        raise InputError(f"target {path}: expected three numbers on each line")
    return table
