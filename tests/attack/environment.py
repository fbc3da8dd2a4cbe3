"""What the user's environment holds, in processes of their own: it is no input."""

from __future__ import annotations

import hashlib
import random
import resource
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from attack.attempt import Attempt, Right

SOLVE = (
    "solve",
    "s.toml",
    "--solver",
    "dshell",
    "--set",
    "solver.total_time=0.002",
    "--model",
    "paper",
    "-o",
    "a.nc",
    "--quiet",
)
MESH = ("mesh", "s.toml", "-o", "m.vtu", "--quiet")
PLOT = ("plot", "good.nc", "-o", "a.png")
INFO = ("info", "good.nc")
MADE = {MESH: ("m.vtu", "m.vtu.png"), SOLVE: ("a.nc",), PLOT: ("a.png",), INFO: ()}


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    same = _same_mesh(bench)

    def of(
        name: str,
        words: tuple[str, ...] = SOLVE,
        right: Right = Right.ACCEPTED,
        made: dict[str, Any] | None = None,
        check: Callable[[Path, str], str] | None = None,
        streams: dict[int, str] | None = None,
        limits: dict[int, int] | None = None,
        says: str = "",
        **variables: str | None,
    ) -> Attempt:
        files = {"s.toml": bench.specimen, "good.nc": bench.result, **(made or {})}
        outputs = (*MADE.get(words, ()), "../h/.cache*", "../h/.config*", "home_*/.c*")
        makes = MADE.get(words, ()) if right is Right.ACCEPTED else ()
        return Attempt(
            "environment",
            f"{words[0]}: {name}",
            words,
            files,
            right,
            outputs,
            makes,
            says=says,
            check=check,
            variables=variables,
            fresh=True,
            streams=streams or {},
            limits=limits or {},
        )

    for words in (MESH, PLOT):
        for backend in (
            "module://matplotlib_inline.backend_inline",
            "nonsense",
            "",
            "TkAgg",
            "pdf",
        ):
            yield of(f"MPLBACKEND={backend}", words, MPLBACKEND=backend)
    yield of("a matplotlibrc of nonsense", PLOT, made={"matplotlibrc": "backend: nonsense\nx\n"})
    binary = {"matplotlibrc": bytes(range(256))}
    yield of("a matplotlibrc of binary", PLOT, Right.HANDLED, made=binary)
    yield of("text by TeX", PLOT, made={"matplotlibrc": "text.usetex: True\n"})
    for option in (
        "Mesh.MeshSizeFactor = 0.5;",
        "Mesh.ElementOrder = 2;",
        "Mesh.RecombineAll = 1;",
        "Mesh.CharacteristicLengthMax = 0.004;",
        "nonsense",
        "Exit;",
        "Mesh.Algorithm = 8;",
        "General.NumThreads = 3;",
    ):
        for file in (".gmshrc", ".gmsh-options"):
            home = f"home_{file[1:]}"
            yield of(
                f"~/{file} {option}",
                MESH,
                made={f"{home}/{file}": option + "\n"},
                check=same,
                HOME=home,
                GMSH_HOME=home,
            )
    for name in (".gmshrc", ".gmsh-options", "gmshrc"):
        yield of(f"./{name}", MESH, made={name: "Mesh.MeshSizeFactor = 0.5;\n"}, check=same)
    for name, home in {
        "unset": None,
        "empty": "",
        "gone": "/nowhere",
        "a file": "s.toml",
        "read-only": "/proc",
        "relative": ".",
    }.items():
        for words in (SOLVE, MESH):
            yield of(f"HOME {name}", words, HOME=home)
    for name, folder in {
        "gone": "/nowhere",
        "a file": "s.toml",
        "read-only": "/proc",
        "empty": "",
        "relative": "none",
        "long": "long/" + "n" * 120,
    }.items():
        made = {folder + "/x": b""} if name == "long" else {}
        for words in (SOLVE, MESH):
            yield of(f"TMPDIR {name}", words, made=made, TMPDIR=folder)
    for cache in ("/nowhere", "/proc", "", "s.toml"):
        yield of(f"XDG_CACHE_HOME={cache}", PLOT, XDG_CACHE_HOME=cache)
        yield of(f"MPLCONFIGDIR={cache}", PLOT, MPLCONFIGDIR=cache)
    for language in ("C", "nonsense", "de_DE.UTF-8", "ja_JP.SJIS", ""):
        yield of(f"LC_ALL={language}", INFO, LC_ALL=language, LANG=language)
    for encoding in ("ascii", "latin-1", "utf-16"):
        yield of(f"PYTHONIOENCODING={encoding}", INFO, PYTHONIOENCODING=encoding)
    yield of("PYTHONUTF8=0 in C", INFO, PYTHONUTF8="0", LC_ALL="C", PYTHONCOERCECLOCALE="0")
    for columns in ("0", "-5", "1", "x", "9" * 30, ""):
        yield of(f"COLUMNS={columns}", ("solve", "--help"), COLUMNS=columns)
        yield of(f"COLUMNS={columns}", INFO, COLUMNS=columns)
    for threads in ("x", "0", "-1", "", "99999"):
        yield of(f"OMP_NUM_THREADS={threads}", SOLVE, right=Right.HANDLED, OMP_NUM_THREADS=threads)
    for name, value in {
        "GIT_DIR": "/nowhere",
        "GIT_WORK_TREE": "/nowhere",
        "GIT_INDEX_FILE": "/nowhere",
        "GIT_CEILING_DIRECTORIES": "/",
        "GIT_TRACE": "1",
        "PAGER": "false",
        "GIT_CONFIG_COUNT": "x",
    }.items():
        yield of(f"{name}={value}", SOLVE, **{name: value})
    yield of("no PATH", SOLVE, PATH="")
    yield of("HDF5_USE_FILE_LOCKING=nonsense", INFO, HDF5_USE_FILE_LOCKING="nonsense")
    yield of("HDF5_PLUGIN_PATH gone", INFO, HDF5_PLUGIN_PATH="/nowhere")
    yield of("HDF5_DRIVER=nonsense", INFO, Right.HANDLED, HDF5_DRIVER="nonsense")
    for name in (".ncrc", ".dodsrc", ".daprc", ".netrc"):
        yield of(f"{name} of nonsense", INFO, made={name: "HTTP.PROXY=\x01\n[x\n"}, HOME=".")
    for name in (
        "numpy.py",
        "bilayer.py",
        "gmsh.py",
        "tomllib.py",
        "dshell.py",
        "sitecustomize.py",
    ):
        yield of(f"{name} in the folder", SOLVE, made={name: "raise SystemExit('taken')\n"})
    yield of("PYTHONWARNINGS=error", INFO, Right.HANDLED, PYTHONWARNINGS="error::UserWarning")
    yield of("PYTHONOPTIMIZE=2", ("solve", "--help"), PYTHONOPTIMIZE="2")
    yield of("PYTHONOPTIMIZE=2", SOLVE, PYTHONOPTIMIZE="2")
    for words in (INFO, ("init",), SOLVE, ("--version",), ("solve", "--help")):
        yield of("stdout closed", words, streams={1: "closed"})
        yield of("stderr closed", words, streams={2: "closed"})
        yield of("all closed", words, streams={0: "closed", 1: "closed", 2: "closed"})
    for words in (("info", "none.nc"), ("frobnicate",)):
        yield of("bad input, stderr closed", words, Right.REFUSED, streams={2: "closed"})
    yield of("12 files at a time", SOLVE, Right.HANDLED, limits={resource.RLIMIT_NOFILE: 12})
    yield of("1 MB for a file", SOLVE, Right.HANDLED, limits={resource.RLIMIT_FSIZE: 10_000})
    yield of("no file at all", SOLVE, Right.HANDLED, limits={resource.RLIMIT_FSIZE: 0})
    yield of("no file at all", PLOT, Right.HANDLED, limits={resource.RLIMIT_FSIZE: 0})
    yield of("no file at all", MESH, Right.HANDLED, limits={resource.RLIMIT_FSIZE: 0})
    yield of("a gigabyte of memory", SOLVE, Right.HANDLED, limits={resource.RLIMIT_AS: 2**30})


def _same_mesh(bench: Any) -> Callable[[Path, str], str]:
    """Return a check that the mesh is the one of an empty environment."""

    def check(folder: Path, said: str) -> str:
        import bilayer

        plain = bilayer.generate_mesh(bilayer.read_specimen(bench.specimen))
        found = bilayer.read_planar_mesh(folder / "m.vtu")
        return (
            ""
            if _digest(found) == _digest(plain)
            else f"another mesh: {len(found.triangles)} triangles"
        )

    return check


def _digest(mesh: Any) -> str:
    return hashlib.sha1(mesh.points.tobytes() + mesh.triangles.tobytes()).hexdigest()
