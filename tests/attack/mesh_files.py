"""Meshes from elsewhere: of another specimen, of no sheet, with other tags, and damaged files."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from attack.attempt import Attempt, Right
from attack.values import NO_FILES

FORMATS = (
    "msh",
    "vtu",
    "vtk",
    "xdmf",
    "stl",
    "obj",
    "ply",
    "off",
    "inp",
    "med",
    "su2",
    "nas",
    "dat",
    "mesh",
    "e",
    "svg",
    "nc",
    "f3grid",
    "wkt",
    "h5m",
    "tec",
    "ugrid",
    "cgns",
)
UNCLEAR = ("named otherwise", "partly tagged", "numbered")
"""Groups of gmsh that may stand for nothing."""
Points = np.ndarray


def words(specimen: str, mesh: str) -> tuple[str, ...]:
    return ("export", specimen, "--mesh", mesh, "-o", "d.inp", "--quiet")


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    for name, (points, cells, region, right, specimen) in _meshes(bench).items():
        for ending in ("vtu", "msh", "vtk"):
            made = _writer(points, cells, region, ending)
            yield _attempt(bench, f"{name} ({ending})", made, f"m.{ending}", specimen, right)
    yield from _of_other_results(bench)
    yield from _of_gmsh(bench)
    yield from _damaged(bench, chance)
    yield from _no_files(bench)


def _attempt(
    bench: Any,
    name: str,
    content: Any,
    file: str,
    specimen: str,
    right: Right,
    says: str | None = None,
    check: Any = None,
) -> Attempt:
    files = {"s.toml": bench.specimen, "uncut.toml": bench.uncut, file: content}
    says = rf"mesh|{file}" if says is None and right is Right.REFUSED else says or ""
    return Attempt(
        "mesh file", name, words(specimen, file), files, right, ("d.inp",), says=says, check=check
    )


@cache
def _generated(specimen: Path) -> Any:
    import bilayer

    return bilayer.generate_mesh(bilayer.read_specimen(specimen))


def _writer(points: Points, cells: Any, region: Any, ending: str) -> Callable[[Path], None]:
    def make(path: Path) -> None:
        names = ["gmsh:physical", "gmsh:geometrical"] if ending == "msh" else ["region"]
        data = {} if region is None else dict.fromkeys(names, region)
        mesh = meshio.Mesh(points, cells, cell_data=data)
        meshio.write(path, mesh, file_format="gmsh22" if ending == "msh" else None)

    return make


def _meshes(bench: Any) -> dict[str, tuple[Any, Any, Any, Right, str]]:
    """Return points, cells, regions, what is right, and the specimen, by what is odd about them."""
    cut, whole = _generated(bench.specimen), _generated(bench.uncut)
    flat = np.pad(cut.points, ((0, 0), (0, 1)))
    region = cut.region.astype(np.int32)
    cells = [("triangle", cut.triangles)]
    made: dict[str, tuple[Any, Any, Any, Right, str]] = {}

    def add(
        name: str,
        points: Any = flat,
        cells: Any = cells,
        region: Any = region,
        right: Right = Right.REFUSED,
        specimen: str = "s.toml",
    ) -> None:
        listed = None if region is None else [np.asarray(region, dtype=np.int32)]
        made[name] = points, cells, listed, right, specimen

    add("good: as it is", right=Right.ACCEPTED)
    add("good: in another plane", flat + np.array([0, 0, 0.5]), right=Right.ACCEPTED)
    add(
        "good: on the uncut specimen, which it defines", right=Right.ACCEPTED, specimen="uncut.toml"
    )
    for factor in (1.03, 2.0, 0.5, 0.97, 1000.0, 0.001):
        add(f"{factor:g} times as large", factor * flat)
    add("moved by half the radius", flat + np.array([0.02, 0, 0]))
    add("moved far away", flat + np.array([1e6, 0, 0]))
    add("stretched along x", flat * [1.1, 1, 1])
    add("sheared", flat + 0.2 * flat[:, [1, 0, 2]] * [1, 0, 0])
    add("turned by half a strip", _turned(flat, np.pi / 5))
    add("turned by a little", _turned(flat, 0.15))
    add(
        "upside down",
        flat * [1, -1, 1],
        [("triangle", cut.triangles[:, ::-1])],
        right=Right.ACCEPTED,
    )
    add("bent", flat + np.column_stack([0 * flat[:, 0], 0 * flat[:, 0], 10 * flat[:, 0] ** 2]))
    add("upright", flat[:, [0, 2, 1]])
    half = cut.points[cut.triangles].mean(axis=1)[:, 0] > 0
    add("half the disc", cells=[("triangle", cut.triangles[half])], region=region[half])
    inside = np.linalg.norm(cut.points[cut.triangles].mean(axis=1), axis=1) > 0.012
    add("with a hole", cells=[("triangle", cut.triangles[inside])], region=region[inside])
    add("all kirigami", region=np.ones_like(region))
    add("all bare", region=np.zeros_like(region))
    add("bare and kirigami exchanged", region=1 - region)
    add("one triangle of another layer", region=_put(region, int(np.argmax(region)), 0))
    add("without a region", region=None)
    for tag in (2, 7, -1, 2**31 - 1, 100):
        add(f"a region of {tag}", region=np.full_like(region, tag))
        add(f"one region of {tag}", region=_put(region, 0, tag))
    add("clockwise", cells=[("triangle", cut.triangles[:, ::-1])], right=Right.EITHER)
    add("one triangle clockwise", cells=[("triangle", _flip(cut.triangles, 0))], right=Right.EITHER)
    add(
        "every triangle twice",
        cells=[("triangle", np.tile(cut.triangles, (2, 1)))],
        region=np.tile(region, 2),
    )
    twice = np.concatenate([cut.triangles, cut.triangles + len(flat)])
    add(
        "two discs, one upon the other",
        np.tile(flat, (2, 1)),
        [("triangle", twice)],
        np.tile(region, 2),
    )
    add(
        "two discs, side by side",
        np.concatenate([flat, flat + np.array([1, 0, 0])]),
        [("triangle", twice)],
        np.tile(region, 2),
    )
    add(
        "a triangle without area",
        cells=[("triangle", _put(cut.triangles, (0, 1), cut.triangles[0, 0]))],
    )
    add("a triangle turned over by its node", _put(flat, cut.centre_node, [0.03, 0.01, 0]))
    for bad in (np.nan, np.inf, 1e300):
        add(f"a node at {bad}", _put(flat, (3, 0), bad))
        add(f"all nodes at {bad}", np.full_like(flat, bad))
    add("all nodes at 0", 0 * flat)
    add("without triangles", cells=[("line", np.array([[0, 1]]))], region=None)
    add(
        "lines and triangles",
        cells=[*cells, ("line", cut.boundary_edges)],
        right=Right.EITHER,
        region=None,
    )
    squares = np.column_stack([cut.triangles, cut.triangles[:, 0]])
    add("quadrangles", cells=[("quad", squares)])
    add(
        "tetrahedra",
        flat + np.random.default_rng(1).normal(0, 1e-3, flat.shape),
        [("tetra", squares)],
    )
    add("one triangle", flat[:3], [("triangle", np.array([[0, 1, 2]]))], [1])
    add(
        "uncut good: without a region",
        np.pad(whole.points, ((0, 0), (0, 1))),
        [("triangle", whole.triangles)],
        None,
        Right.ACCEPTED,
        "uncut.toml",
    )
    add(
        "uncut: all bare",
        np.pad(whole.points, ((0, 0), (0, 1))),
        [("triangle", whole.triangles)],
        0 * whole.region,
        Right.EITHER,  # in gmsh's format 0 is no group, and all layers lie everywhere
        "uncut.toml",
    )
    add(
        "uncut: a node of none",
        np.pad(np.vstack([whole.points, [[0.001, 0.001]]]), ((0, 0), (0, 1))),
        [("triangle", whole.triangles)],
        whole.region,
        Right.EITHER,  # in gmsh's format it may be the centre of a circle
        "uncut.toml",
    )
    return made


def _turned(points: Points, angle: float) -> Points:
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def _put(array: Any, index: Any, value: Any) -> Any:
    changed = np.array(array)
    changed[index] = value
    return changed


def _flip(triangles: Any, number: int) -> Any:
    changed = np.array(triangles)
    changed[number] = changed[number, ::-1]
    return changed


def _of_other_results(bench: Any) -> Iterator[Attempt]:
    """Yield the meshes of results of other specimens."""
    import bilayer

    for name, (overrides, right) in {
        "good: the same": ([], Right.ACCEPTED),
        "good: another thickness": (["substrate.thickness=0.0005"], Right.ACCEPTED),
        "three strips": (["cut.strips=3"], Right.REFUSED),
        "six strips": (["cut.strips=6"], Right.REFUSED),
        "a wider cut": (["cut.cutout_angle=0.6"], Right.REFUSED),
        "a cut from further out": (["cut.inner_radius=0.02"], Right.REFUSED),
        "a larger disc": (["specimen.outer_radius=0.045"], Right.REFUSED),
    }.items():

        def make(path: Path, overrides: list[str] = overrides) -> None:
            specimen = bilayer.read_specimen(bench.specimen, overrides)
            settings = bilayer.PaperSettings(total_time=0.002)
            bilayer.solve(specimen, "dshell", settings, output=path)

        yield _attempt(bench, f"of a result: {name}", make, "r.nc", "s.toml", right)


def _of_gmsh(bench: Any) -> Iterator[Attempt]:
    """Yield what gmsh itself writes: names, versions, all entities, partly tagged."""
    for version in (2.2, 4.0, 4.1):
        for binary in (0, 1):
            for save_all in (0, 1):
                for name, groups in {
                    "named": {"bare": 1, "kirigami": 2},
                    "numbered": {None: 1},
                    "named after layers": {"substrate": 1, "kirigami": 2},
                    "untagged": {},
                    "partly tagged": {"kirigami": 2},
                    "named otherwise": {"left": 1, "right": 2},
                }.items():
                    if binary and version == 4.0:
                        continue  # gmsh does not write it
                    loses_groups = version == 2.2 and save_all
                    right = Right.ACCEPTED
                    if version == 4.0 or loses_groups or name in UNCLEAR:
                        right = Right.EITHER

                    def make(
                        path: Path,
                        version: float = version,
                        binary: int = binary,
                        save_all: int = save_all,
                        groups: dict = groups,
                    ) -> None:
                        _gmsh_disc(path, version, binary, save_all, groups)

                    label = f"gmsh {version:g} binary={binary} all={save_all} {name}"
                    yield _attempt(bench, label, make, "g.msh", "uncut.toml", right)


def _gmsh_disc(path: Path, version: float, binary: int, save_all: int, groups: Any) -> None:
    """Write a disc of two surfaces, an inner disc and a ring, as gmsh's own drawing."""
    import gmsh

    gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Verbosity", 0)
        geo = gmsh.model.geo
        centre = geo.addPoint(0, 0, 0, 0.02)
        rings = []
        for radius in (0.02, 0.04):
            at = [
                geo.addPoint(radius * x, radius * y, 0, 0.012)
                for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1))
            ]
            arcs = [geo.addCircleArc(at[k], centre, at[(k + 1) % 4]) for k in range(4)]
            rings.append(geo.addCurveLoop(arcs))
        inner = geo.addPlaneSurface([rings[0]])
        outer = geo.addPlaneSurface([rings[1], rings[0]])
        geo.synchronize()
        for name, number in groups.items():
            tag = gmsh.model.addPhysicalGroup(2, [inner if number == 2 else outer], number)
            if name:
                gmsh.model.setPhysicalName(2, tag, name)
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.option.setNumber("Mesh.SaveAll", save_all)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def _damaged(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    """Yield files of which some letters are changed, or which end too early."""
    cut = _generated(bench.specimen)
    mesh = meshio.Mesh(np.pad(cut.points, ((0, 0), (0, 1))), [("triangle", cut.triangles)])
    place = bench.folder / "meshes"
    place.mkdir()
    tags = [cut.region.astype(np.int32)]
    for kind, ending in (
        ("gmsh22", "msh"),
        ("gmsh", "msh"),
        ("vtk", "vtk"),
        ("vtu", "vtu"),
        ("obj", "obj"),
        ("xdmf", "xdmf"),
        ("medit", "mesh"),
        ("abaqus", "inp"),
        ("stl", "stl"),
        ("ply", "ply"),
        ("off", "off"),
    ):
        file = place / f"{kind}.{ending}"
        names = ("gmsh:physical", "gmsh:geometrical") if "gmsh" in kind else ("region",)
        data = dict.fromkeys(names, tags) if kind in ("gmsh22", "gmsh", "vtk", "vtu") else {}
        if kind == "gmsh":
            _gmsh_disc(file, 4.1, 0, 0, {"bare": 1, "kirigami": 2})
        else:
            meshio.write(
                file, meshio.Mesh(mesh.points, mesh.cells, cell_data=data), file_format=kind
            )
        whole = file.read_bytes()
        for number in range(8):
            end = chance.randrange(len(whole) - 2)
            yield _attempt(
                bench,
                f"{kind} cut off {number}",
                whole[:end],
                f"m.{ending}",
                "s.toml",
                Right.EITHER,
            )
        for number in range(16):
            damaged = bytearray(whole)
            for _ in range(chance.choice((1, 2, 8))):
                damaged[chance.randrange(len(damaged))] = chance.choice(
                    b'0123456789.-+eE \n\0a$<>"'
                )
            yield _attempt(
                bench,
                f"{kind} changed {number}",
                bytes(damaged),
                f"m.{ending}",
                "s.toml",
                Right.EITHER,
            )
    for ending in FORMATS:
        for name, content in {
            "empty": b"",
            "zeros": bytes(500),
            "a text": b"hello\nworld\n",
            "binary": bytes(range(256)) * 4,
            "another format": b"# vtk DataFile Version 5.1\nx\nASCII\n",
        }.items():
            yield _attempt(
                bench, f".{ending} {name}", content, f"m.{ending}", "s.toml", Right.REFUSED
            )


def _no_files(bench: Any) -> Iterator[Attempt]:
    for ending in ("msh", "vtu", "nc", "stl"):
        for name, make in {
            **NO_FILES,
            "nothing": lambda path: path.symlink_to("/dev/null"),
            "noise without end": lambda path: path.symlink_to("/dev/urandom"),
        }.items():
            yield _attempt(
                bench,
                f"{name}.{ending}",
                make,
                f"m.{ending}",
                "s.toml",
                Right.REFUSED,
                says=f"m.{ending}",
            )
    huge = b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1000000000000\n1 0 0 0\n$EndNodes\n"
    yield _attempt(bench, "1e12 nodes promised", huge, "m.msh", "s.toml", Right.REFUSED)
    bomb = (
        "<?xml version='1.0'?><!DOCTYPE x [<!ENTITY a 'aaaaaaaaaa'>"
        + "".join(f"<!ENTITY {chr(98 + k)} '{f'&{chr(97 + k)};' * 10}'>" for k in range(10))
        + "]><VTKFile type='UnstructuredGrid' version='0.1'>&k;</VTKFile>"
    )
    yield _attempt(bench, "a bomb of entities", bomb, "m.vtu", "s.toml", Right.REFUSED)
    stolen = (
        "<?xml version='1.0'?><!DOCTYPE x [<!ENTITY a SYSTEM 'file:///etc/passwd'>]>"
        "<VTKFile type='UnstructuredGrid' version='0.1'>&a;</VTKFile>"
    )
    yield _attempt(bench, "an entity of another file", stolen, "m.vtu", "s.toml", Right.REFUSED)
