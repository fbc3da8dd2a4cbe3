"""Files of gmsh (.msh): their mesh, and the physical groups that each surface is in.

meshio reads the mesh. Of version 4 it reads one group of a surface at most, and refuses files of
which only some surfaces are in a group, so their section `$Entities` is read here and kept from it.
"""

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import meshio

SURFACE = 2
"""Dimension of the groups that are of interest."""


@dataclass(frozen=True, eq=False)
class PhysicalGroups:
    """The physical groups that the triangles of a file are in.

    Parameters
    ----------
    names : mapping of int to str
        Of the groups that have one, by their tag.
    sets : sequence of frozenset of int
        The different sets of groups, by their tags, that a triangle is in.
    number : (m,) array of int
        For each triangle which of these it is.
    """

    names: Mapping[int, str]
    sets: tuple[frozenset[int], ...]
    number: NDArray[np.int64]

    @property
    def ungrouped(self) -> int:
        """Number of triangles that are in no group."""
        return int(np.isin(self.number, [k for k, tags in enumerate(self.sets) if not tags]).sum())


def is_gmsh(content: bytes) -> bool:
    """Whether a file of this content is gmsh's: it begins with its format, or a comment."""
    return content.lstrip()[:11] in (b"$MeshFormat", b"$Comments\n", b"$Comments\r")


def read_gmsh(path: str | Path, content: bytes) -> "tuple[meshio.Mesh, PhysicalGroups]":
    """Return the mesh and the groups of a file.

    Parameters
    ----------
    path : path-like
        The file.
    content : bytes
        Of the file.

    Raises
    ------
    Exception
        Of any kind: the file is damaged.
    """
    import meshio  # takes long to load, and few need it

    _check_version(content)
    names = _surface_names(content)
    if _section(content, "PartitionedEntities") is not None:
        raise ValueError("is partitioned, expected the whole mesh in one part")
    entities = _section(content, "Entities")
    if entities is None:
        return _each_triangle_once(meshio.gmsh.read(path), names)
    of_surface = _groups_of_surfaces(content, entities)
    with tempfile.TemporaryDirectory() as folder:
        without = Path(folder, "mesh.msh")
        without.write_bytes(content.replace(entities, b""))
        mesh = meshio.gmsh.read(without)
    surfaces, number = np.unique(_cell_data(mesh, "gmsh:geometrical"), return_inverse=True)
    sets = tuple(of_surface[int(surface)] for surface in surfaces)
    return mesh, PhysicalGroups(names, sets, number)


def groups_by_tag(tags: NDArray[np.int64], names: Mapping[int, str]) -> PhysicalGroups:
    """Return the groups of triangles that are in one at most, by its tag, shape (m,); 0 is none."""
    found, number = np.unique(tags, return_inverse=True)
    return PhysicalGroups(
        names, tuple(frozenset({int(tag)} if tag else ()) for tag in found), number
    )


def _each_triangle_once(
    mesh: "meshio.Mesh", names: Mapping[int, str]
) -> "tuple[meshio.Mesh, PhysicalGroups]":
    """Return a mesh of version 2.2, where a triangle stands once for each group that it is in."""
    triangles, tags = mesh.get_cells_type("triangle"), _cell_data(mesh, "gmsh:physical")
    _, first, one = np.unique(np.sort(triangles), axis=0, return_index=True, return_inverse=True)
    pairs = np.unique(np.column_stack([one.reshape(-1), tags]), axis=0)
    if len(first) == len(triangles) or len(pairs) < len(triangles):
        return mesh, groups_by_tag(tags, names)  # none comes twice, or one in the same group
    known, column = np.unique(pairs[:, 1], return_inverse=True)
    is_in = np.zeros((len(first), len(known)), dtype=bool)
    is_in[pairs[:, 0], column] = True
    kept = np.argsort(first)  # in the order of the file
    rows, number = np.unique(is_in[kept], axis=0, return_inverse=True)
    sets = tuple(frozenset(known[row].tolist()) - {0} for row in rows)
    others = [block for block in mesh.cells if block.type != "triangle"]
    once = type(mesh)(mesh.points, [*others, ("triangle", triangles[np.sort(first)])])
    return once, PhysicalGroups(names, sets, number.reshape(-1))


def _cell_data(mesh: "meshio.Mesh", name: str) -> NDArray[np.int64]:
    """Return numbers of the triangles, 0 if the file has none."""
    count = len(mesh.get_cells_type("triangle"))
    if count == 0 or name not in mesh.cell_data:
        return np.zeros(count, dtype=np.int64)
    found: NDArray[np.int64] = mesh.get_cell_data(name, "triangle")
    return found


def _section(content: bytes, name: str) -> bytes | None:
    """Return a section with the lines that begin and end it; None if there is none."""
    begin, end = f"${name}".encode(), f"$End{name}".encode()
    for line_end in (b"\n", b"\r\n"):
        start = content.find(begin + line_end)
        if start >= 0:
            stop = content.index(end, start) + len(end)
            return content[start:stop]
    return None


def _surface_names(content: bytes) -> dict[int, str]:
    """Return the names of the groups of surfaces, each line a dimension, a tag and a name."""
    lines = (_section(content, "PhysicalNames") or b"").decode().splitlines()[2:-1]
    rows = [line.split(maxsplit=2) for line in lines if line.strip()]
    return {int(tag): name.strip().strip('"') for dim, tag, name in rows if int(dim) == SURFACE}


def _groups_of_surfaces(content: bytes, section: bytes) -> dict[int, frozenset[int]]:
    """Return the tags of the groups of each surface, by the surface's tag."""
    _, is_binary, size = _format(content)
    numbers = _Numbers(section, is_binary, size)
    counts = [numbers.take_size() for _ in range(4)]
    groups: dict[int, frozenset[int]] = {}
    for dimension, count in enumerate(counts[: SURFACE + 1]):
        for _ in range(count):
            tag = numbers.take_int()
            numbers.skip_reals(3 if dimension == 0 else 6)
            tags = [numbers.take_int() for _ in range(numbers.take_size())]
            if dimension > 0:
                for _ in range(numbers.take_size()):
                    numbers.take_int()
            if dimension == SURFACE:
                groups[tag] = frozenset(map(abs, tags))  # negative: turned over
    return groups


def _format(content: bytes) -> tuple[str, bool, int]:
    """Return the version, whether the file is binary, and the bytes of its whole numbers."""
    start = content.index(b"$MeshFormat")
    version, kind, size = content[start:].split(maxsplit=4)[1:4]
    return version.decode(), kind == b"1", int(size)


def _check_version(content: bytes) -> None:
    """Raise ValueError unless the file is of a version that is read; gmsh calls 4.0 "4", too."""
    version, _, _ = _format(content)
    nodes = (_section(content, "Nodes") or b"").splitlines()[1:2] or [b""]
    is_4_0 = version == "4.0" or (version == "4" and len(nodes[0].split()) == 2)
    if is_4_0 or version.split(".")[0] not in ("2", "4"):
        raise ValueError(f"is of gmsh's version {version}, expected 2.2 or 4.1")


class _Numbers:
    """The numbers of a section one by one, from text or from bytes."""

    def __init__(self, section: bytes, is_binary: bool, size: int) -> None:
        first = section.index(b"\n") + 1
        last = section.rindex(b"$")
        self._content = section[first:last]
        self._place, self._is_binary = 0, is_binary
        self._words = [] if is_binary else self._content.split()
        self._size = np.dtype(f"u{size}")

    def take_int(self) -> int:
        return int(self._take(np.dtype("i4")))

    def take_size(self) -> int:
        return int(self._take(self._size))

    def skip_reals(self, count: int) -> None:
        self._place += 8 * count if self._is_binary else count

    def _take(self, kind: np.dtype[Any]) -> Any:
        if not self._is_binary:
            self._place += 1
            return self._words[self._place - 1]
        value: NDArray[Any] = np.frombuffer(self._content, kind, 1, self._place)
        self._place += kind.itemsize
        return value[0]
