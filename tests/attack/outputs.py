"""Outputs that are devices, links, folders, inputs, or cannot be made; formats that lose layers."""

from __future__ import annotations

import os
import random
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from attack.attempt import Attempt, Right
from attack.measurement_files import table

LATIN = os.fsdecode(b"r\xe9sultat")


def _verbs(bench: Any) -> dict[str, tuple[tuple[str, ...], str]]:
    """Return for each verb that writes its words, and the ending of what it writes."""
    quick = ("--set", "solver.total_time=0.002", "--model", "paper")
    return {
        "solve": (("solve", "s.toml", "--solver", "dshell", "--quiet", *quick), "nc"),
        "mesh": (("mesh", "s.toml", "--quiet"), "vtu"),
        "export": (("export", "s.toml", "--quiet"), "inp"),
        "cut": (("cut", "s.toml", "--quiet", "--layer", "kirigami"), "dxf"),
        "fit": (("fit", "t.csv", "--law", "neo-hookean"), "png"),
        "plot": (("plot", "good.nc"), "png"),
        "convert": (("convert", "good.nc"), "vtu"),
        "view": (("view", "good.nc", "--no-open", "--quiet"), "html"),
        "compare": (("compare", "good.nc", "good.nc", "--quiet"), "png"),
        "rerun": (("rerun", "good.nc", "--quiet"), "nc"),
        "import": (("import", "d/deck.frd", "uncut.toml", "--prestretch", "1.03", "--quiet"), "nc"),
        "plot-study": (
            ("plot-study", "w/st", "--x", "cut.cutout_angle", "--prestretch", "1.001"),
            "png",
        ),
    }


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    for verb, (words, ending) in _verbs(bench).items():
        yield from _of_verb(bench, verb, words, ending)
    yield from _inputs_as_outputs(bench)
    yield from _endings(bench)
    yield from _regions(bench)
    yield from _pictures(bench)


def _files(bench: Any, verb: str) -> dict[str, Any]:
    files: dict[str, Any] = {"s.toml": bench.specimen, "good.nc": bench.result}
    if verb == "import":
        files |= {"uncut.toml": bench.uncut, "d": bench.deck}
    if verb == "plot-study":
        files["w"] = bench.study
    if verb == "fit":
        files["t.csv"] = table()
    return files


def _of_verb(bench: Any, verb: str, words: tuple[str, ...], ending: str) -> Iterator[Attempt]:
    def of(
        name: str,
        output: str,
        right: Right = Right.REFUSED,
        made: dict[str, Any] | None = None,
        outputs: tuple[str, ...] = (),
        **more: Any,
    ) -> Attempt:
        files = _files(bench, verb) | (made or {})
        also = outputs
        if verb == "mesh" and outputs:
            also = (*outputs, *(f"{o}.png" for o in outputs))
        return Attempt(
            "output",
            f"{verb} -o {name}",
            (*words, f"--output={output}"),
            files,
            right,
            also,
            **more,
        )

    out = f"a.{ending}"
    yield of("empty", "")
    yield of("a blank", " ", Right.REFUSED)
    yield of("the folder", ".")
    yield of("the folder above", "..")
    yield of("the root", "/")
    yield of("a folder", "f", made={"f": lambda path: path.mkdir()})
    yield of("a folder with the ending", out, made={out: lambda path: path.mkdir()})
    yield of("in no folder", f"none/{out}", says="none")
    yield of("in a file", f"s.toml/{out}")
    yield of("with a slash", f"{out}/")
    yield of("too long", f"{'n' * 300}.{ending}")
    yield of("far too long", f"{'n' * 5000}.{ending}")
    yield of("/proc", f"/proc/{out}")
    yield of("only an ending", f".{ending}", Right.EITHER, outputs=(f".{ending}", "*.png"))
    yield of(
        "no ending",
        "a",
        Right.REFUSED if verb not in ("import", "solve", "rerun") else Right.EITHER,
        outputs=("a",),
    )
    for name, make in {"a pipe": os.mkfifo, "a device": _null}.items():
        yield of(name, out, made={out: make})
    yield of("a link to a device", out, made={"d0": _null, out: lambda path: path.symlink_to("d0")})
    yield of("a link to itself", out, made={out: lambda path: path.symlink_to(path.name)})
    yield of("a link to a folder", out, made={"f/x": b"", out: lambda path: path.symlink_to("f")})
    yield of("a link to no folder", out, made={out: lambda path: path.symlink_to("none/x")})

    def link_check(folder: Path, said: str) -> str:
        if not (folder / out).is_symlink():
            return "the link was replaced by a file"
        return (
            ""
            if (folder / f"real.{ending}").stat().st_size > 10
            else "nothing was written through the link"
        )

    real = {f"real.{ending}": b"old", out: lambda path: path.symlink_to(f"real.{ending}")}
    through = (f"real.{ending}", f"{out}.png")
    yield of("a link to a file", out, Right.ACCEPTED, real, through, check=link_check)
    to_none = {out: lambda path: path.symlink_to(f"real.{ending}")}
    yield of(
        "a link to a file that is not there yet",
        out,
        Right.EITHER,
        to_none,
        through,
    )
    for name, output in {
        "good": out,
        "good: with a dollar": f"$x$.{ending}",
        "good: with blanks": f" a b .{ending}",
        "good: in Unicode": f"日本é.{ending}",
        "good: with a brace": f"{{0}}%s.{ending}",
        "good: of some length": f"{'n' * 200}.{ending}",
        "good: with dots": f"a.b.c.{ending}",
        "good: with a quote": f"a'b\"c.{ending}",
        "good: with a star": f"a*[b]?.{ending}",
        "good: in capitals": f"A.{ending}",
    }.items():
        globbed = (output.replace("[", "?").replace("]", "?"),)
        yield of(name, output, Right.ACCEPTED, outputs=globbed, makes=(output,))
    yield of("a name in Latin-1", f"{LATIN}.{ending}", Right.EITHER, outputs=("r*",))
    yield of("a name with a newline", f"a\nb.{ending}", Right.EITHER, outputs=("a*b.*",))
    yield of("a name with an escape", f"a\x1b[31m.{ending}", Right.EITHER, outputs=("a*",))
    yield of("over an older one", out, Right.ACCEPTED, {out: b"old"}, (out,), makes=(out,))


def _null(path: Path) -> None:
    """Make a device that takes and gives nothing, or a pipe if this user may not."""
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, 3))
    except PermissionError:
        os.mkfifo(path)


def _inputs_as_outputs(bench: Any) -> Iterator[Attempt]:
    """Yield commands whose output is one of their inputs, by its name or another one."""
    hard = lambda path: os.link(path.parent / "s.toml", path)  # noqa: E731
    soft = lambda path: path.symlink_to("s.toml")  # noqa: E731
    mesh = bench.result
    for name, output, made in (
        ("itself", "s.toml", {}),
        ("by another path", "./s.toml", {}),
        ("by way of a folder", "f/../s.toml", {"f": lambda path: path.mkdir()}),
        ("a link to it", "a.nc", {"a.nc": soft}),
        ("a hard link to it", "a.nc", {"a.nc": hard}),
    ):
        for verb, words in {
            "solve": ("solve", "s.toml", "--solver", "dshell", "--quiet"),
            "mesh": ("mesh", "s.toml", "--quiet"),
            "export": ("export", "s.toml", "--quiet"),
        }.items():
            yield Attempt(
                "output",
                f"{verb}: the specimen, {name}",
                (*words, f"--output={output}"),
                {"s.toml": bench.specimen, **made},
            )
    files = {"s.toml": bench.specimen, "m.nc": mesh, "good.nc": bench.result}
    solve = ("solve", "s.toml", "--solver", "dshell", "--quiet")
    for name, words in {
        "solve: the mesh": (*solve, "--mesh", "m.nc", "-o", "m.nc"),
        "solve: the start": (*solve, "--mesh", "m.nc", "--start", "good.nc", "-o", "good.nc"),
        "rerun: the result": ("rerun", "good.nc", "--quiet", "-o", "good.nc"),
        "convert: the result": ("convert", "good.nc", "-o", "good.nc"),
        "plot: the result": ("plot", "good.nc", "-o", "good.nc"),
        "compare: a result": ("compare", "good.nc", "m.nc", "--quiet", "-o", "good.nc"),
    }.items():
        yield Attempt("output", name, words, files)
    deck = {"uncut.toml": bench.uncut, "d": bench.deck}
    imported = ("import", "d/deck.frd", "uncut.toml", "--prestretch", "1.03", "--quiet", "-o")
    for name in ("d/deck.frd", "d/deck.sta", "uncut.toml"):
        yield Attempt("output", f"import: {name}", (*imported, name), deck)
    study = {"w": bench.study}
    draw = ("plot-study", "w/st", "--x", "cut.cutout_angle", "--prestretch", "1.001", "-o")
    for name in ("w/st/study.csv", "w/st/plan.json", "w/st/cases"):
        yield Attempt("output", f"plot-study: {name}", (*draw, name), study)


def _endings(bench: Any) -> Iterator[Attempt]:
    """Yield endings that promise another format than what is written."""
    for ending in ("txt", "toml", "png", "csv", "msh", "h5", "nc4", "NC", "inp", "zip", ""):
        right = Right.EITHER if ending in ("h5", "nc4", "NC", "") else Right.REFUSED
        name = f"a.{ending}"
        solve = ("solve", "s.toml", "--solver", "dshell", "--quiet", f"--output={name}")
        yield Attempt(
            "output", f"solve -o .{ending}", solve, {"s.toml": bench.specimen}, right, (name,)
        )
    for verb, ending in (
        ("plot", "nc"),
        ("plot", "txt"),
        ("plot", "toml"),
        ("convert", "png"),
        ("convert", "toml"),
        ("convert", "nc"),
        ("plot", "vtu"),
    ):
        yield Attempt(
            "output",
            f"{verb} -o .{ending}",
            (verb, "good.nc", "-o", f"a.{ending}"),
            {"good.nc": bench.result},
        )
    for ending in ("txt", "nc", "toml", "frd", "png"):
        yield Attempt(
            "output",
            f"export -o .{ending}",
            ("export", "s.toml", "--quiet", "-o", f"a.{ending}"),
            {"s.toml": bench.specimen},
        )


def _regions(bench: Any) -> Iterator[Attempt]:
    """Yield all formats of meshes: what is lost in one is told, or the format refused."""
    for ending in sorted(meshio.extension_to_filetypes):
        name = f"m{ending}"

        def check(folder: Path, said: str, name: str = name) -> str:
            import bilayer

            specimen = bilayer.read_specimen(folder / "s.toml")
            bare = int((bilayer.generate_mesh(specimen).region == 0).sum())
            try:
                back = bilayer.read_planar_mesh(folder / name)
            except bilayer.InputError as error:
                return f"what was written cannot be read: {error}"
            found = int(np.sum(back.region == 0))
            return (
                ""
                if found == bare or said.strip()
                else f"{bare} bare triangles are {found}, nothing is said"
            )

        for verb, words in {"mesh": ("mesh", "s.toml", "--quiet")}.items():
            yield Attempt(
                "output",
                f"{verb} -o {name}: the layers",
                (*words, "-o", name),
                {"s.toml": bench.specimen},
                Right.EITHER,
                ("m*",),
                check=check,
            )

        def readable(folder: Path, said: str, name: str = name) -> str:
            try:
                meshio.read(folder / name)
            except BaseException as error:  # meshio ends the process, too
                return f"what was written cannot be read: {type(error).__name__}"
            return ""

        yield Attempt(
            "output",
            f"convert -o {name}",
            ("convert", "good.nc", "-o", name),
            {"good.nc": bench.result},
            Right.EITHER,
            ("m*",),
            check=readable,
        )


PICTURE = "m.vtu.png"


def _pictures(bench: Any) -> Iterator[Attempt]:
    """Yield pictures beside a mesh where another file has their name."""
    words = ("mesh", "s.toml", "--quiet", "-o", "m.vtu")

    def kept(folder: Path, said: str) -> str:
        return "" if (folder / PICTURE).read_bytes() == b"mine" else f"{PICTURE} was overwritten"

    yield Attempt(
        "output",
        "mesh: a picture of one's own is there",
        words,
        {"s.toml": bench.specimen, PICTURE: b"mine"},
        Right.EITHER,
        ("m.vtu",),
        check=kept,
    )
    for name, make in {
        "a pipe": os.mkfifo,
        "a device": _null,
        "a folder": lambda path: path.mkdir(),
        "a link to the specimen": lambda path: path.symlink_to("s.toml"),
    }.items():
        yield Attempt(
            "output",
            f"mesh: the picture would be {name}",
            words,
            {"s.toml": bench.specimen, PICTURE: make},
            Right.EITHER,
            ("m.vtu",),
        )
