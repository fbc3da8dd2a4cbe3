"""Verbs and options: none, unknown, twice, without a value, with one that they do not take."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

from attack.attempt import Attempt, Right
from bilayer.cli.verbs import VERBS

SOLVE = ("solve", "s.toml", "--solver", "dshell", "-o", "a.nc", "--quiet")
NO_NUMBERS = (
    "",
    "x",
    "-1",
    "0",
    "nan",
    "inf",
    "-inf",
    "1e400",
    "9" * 400,
    "1,06",
    "0x10",
    "1.5.2",
    "[]",
    "1_",
    "true",
    "\x1b[31m",
    "1;2",
    "½",
)
NO_COUNTS = (*NO_NUMBERS, "2.5", "1e300", "1e30")


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    yield from _words()
    files = {"s.toml": bench.specimen, "a_good.nc": bench.result}

    def of(name: str, *words: str, right: Right = Right.REFUSED, **more: Any) -> Attempt:
        return Attempt("options", name, words, files, right, **more)

    for value in NO_NUMBERS:
        yield of(f"--mesh-size {value[:9]}", *SOLVE, f"--mesh-size={value}", says="mesh")
        yield of(f"--prestretch {value[:9]}", *SOLVE, f"--prestretch={value}", says="prestretch")
        yield of(
            f"convert --prestretch {value[:9]}",
            "convert",
            "a_good.nc",
            "-o",
            "a.vtu",
            f"--prestretch={value}",
            says="prestretch",
        )
    for value in (
        "1,2,3",
        "1.03,",
        ",1.03",
        "1.03,x",
        "1.03;1.02",
        "1.03, 1.02",
        "1,06",
        "11",
        "[1.03]",
    ):
        right = Right.EITHER if value == "1.03, 1.02" else Right.REFUSED
        yield of(
            f"--prestretch {value}",
            *SOLVE,
            f"--prestretch={value}",
            right=right,
            says="prestretch",
            outputs=("a.nc",),
        )
    for value in ("", "paper ", "Morley", "solid", "x", "\x1b[31m", "morley,hinge"):
        yield of(f"--model {value!r}", *SOLVE, f"--model={value}", says="model")
    for value in ("", "DSHELL", "abaqus", "dshell,fenics", "calculix", "\x1b[2J"):
        yield of(
            f"--solver {value!r}",
            "solve",
            "s.toml",
            f"--solver={value}",
            "-o",
            "a.nc",
            says="solver",
        )
    for value in ("", "none.nc", ".", "s.toml", "/dev/null", "Shell", "flat.nc", "\x1b[31m"):
        yield of(f"--start {value!r}", *SOLVE, f"--start={value}")
    for value in (
        "",
        "none.msh",
        ".",
        "s.toml",
        "/dev/null",
        "none.nc",
        "a.",
        ".msh",
        "\x1b[31m.msh",
    ):
        yield of(f"--mesh {value!r}", *SOLVE, f"--mesh={value}")
    yield of(
        "--resume of no result",
        "solve",
        "s.toml",
        "--solver",
        "dshell",
        "-o",
        "s.toml",
        "--resume",
        "--quiet",
    )
    yield of(
        "--resume of another path",
        "solve",
        "s.toml",
        "--solver",
        "dshell",
        "-o",
        "a_good.nc",
        "--resume",
        "--quiet",
        "--mesh-size",
        "0.03",
    )
    for part in ("", "x", "Volume"):
        yield of(f"convert --part {part!r}", "convert", "a_good.nc", "-o", "a.vtu", "--part", part)
    yield of(
        "convert --all --prestretch",
        "convert",
        "a_good.nc",
        "-o",
        "a.vtu",
        "--all",
        "--prestretch",
        "1.001",
    )
    yield of("convert to no format", "convert", "a_good.nc", "-o", "a")
    yield of("convert to an unknown one", "convert", "a_good.nc", "-o", "a.xyzzy", says="xyzzy")
    yield of("plot to no format", "plot", "a_good.nc", "-o", "a")
    yield of("plot to an unknown one", "plot", "a_good.nc", "-o", "a.xyzzy", says="xyzzy")
    yield of(
        "plot to gif: no nonsense is suggested",
        "plot",
        "a_good.nc",
        "-o",
        "a.gif",
        right=Right.EITHER,
        outputs=("a.gif",),
        says_not="did you mean 'tif'",
    )
    yield of("compare with itself alone", "compare", "a_good.nc")
    yield of("compare three", "compare", "a_good.nc", "a_good.nc", "a_good.nc")
    yield of("rerun two", "rerun", "a_good.nc", "a_good.nc")
    yield from _study_options(bench)
    yield of(
        "good: mesh",
        "mesh",
        "s.toml",
        "-o",
        "m.vtu",
        right=Right.ACCEPTED,
        outputs=("m.vtu", "m.vtu.png"),
        makes=("m.vtu",),
    )
    yield of("good: solve", *SOLVE, right=Right.ACCEPTED, outputs=("a.nc",), makes=("a.nc",))
    yield of(
        "good: solve --resume of nothing",
        *SOLVE,
        "--resume",
        right=Right.ACCEPTED,
        outputs=("a.nc",),
        makes=("a.nc",),
    )
    yield of(
        "good: two stretches",
        *SOLVE,
        "--prestretch",
        "1.001,1.002",
        "1.001",
        right=Right.ACCEPTED,
        outputs=("a.nc",),
        makes=("a.nc",),
    )
    yield of(
        "good: --mesh of a result",
        *SOLVE,
        "--mesh",
        "a_good.nc",
        right=Right.ACCEPTED,
        outputs=("a.nc",),
        makes=("a.nc",),
    )
    yield of("good: info", "info", "a_good.nc", right=Right.ACCEPTED)
    yield of("good: info --specimen", "info", "a_good.nc", "--specimen", right=Right.ACCEPTED)
    yield of("good: compare", "compare", "a_good.nc", "a_good.nc", right=Right.ACCEPTED)
    yield of("good: rerun", "rerun", "a_good.nc", "--quiet", right=Right.ACCEPTED)
    yield of(
        "good: convert --all",
        "convert",
        "a_good.nc",
        "-o",
        "a.vtu",
        "--all",
        right=Right.ACCEPTED,
        outputs=("a_*.vtu",),
        makes=("a_1.001.vtu",),
    )
    yield of(
        "good: plot",
        "plot",
        "a_good.nc",
        "-o",
        "a.png",
        right=Right.ACCEPTED,
        outputs=("a.png",),
        makes=("a.png",),
    )
    yield of(
        "good: export",
        "export",
        "s.toml",
        "-o",
        "d.inp",
        "--quiet",
        right=Right.ACCEPTED,
        outputs=("d.inp",),
        makes=("d.inp",),
    )
    yield of(
        "good: view",
        "view",
        "a_good.nc",
        "--no-open",
        "-o",
        "v.html",
        right=Right.ACCEPTED,
        outputs=("v.html",),
        makes=("v.html",),
    )
    for verb in ("", *VERBS):
        words = (*verb.split(), "--help")
        yield of(f"good: {verb} --help", *words, right=Right.ACCEPTED)
    yield of("good: --version", "--version", right=Right.ACCEPTED)
    yield of(
        "good: --verbose before the verb", "--verbose", "info", "a_good.nc", right=Right.ACCEPTED
    )
    yield of("good: --quiet before the verb", "--quiet", "info", "a_good.nc", right=Right.ACCEPTED)


def _words() -> Iterator[Attempt]:
    def of(name: str, *words: str, **more: Any) -> Attempt:
        return Attempt("options", name, words, **more)

    yield of("nothing at all")
    yield of("an empty word", "")
    yield of("solv is nearly solve", "solv", says="solve'")
    yield of("no verb is near", "xyzzy", says_not="did you mean")
    for word in (
        "-",
        "--",
        "-x",
        "--frobnicate",
        "---",
        "--=",
        "\x1b[31m",
        "a\nb",
        "é",
        "%s",
        "{0}",
        "SOLVE",
        "solve mesh",
        "@file",
        "a" * 100_000,
        "--help=1",
        "-hh=",
        "--version=2",
    ):
        yield of(f"only {word[:12]!r}", word)
    for verb in VERBS:
        if verb not in NEED_NOTHING:
            yield of(f"{verb} alone", verb)
        yield of(f"{verb} --frobnicate", verb, "--frobnicate", says="frobnicate|required")
        yield of(f"{verb} too many", verb, *["x"] * 50)
        yield of(f"{verb} -o without a value", verb, "-o")
        yield of(f"{verb} --quiet=1", verb, "--quiet=1")
        yield of(f"{verb} of nothing there", verb, *_enough(verb, "none"), says="none|--")
        yield of(f"{verb} of an empty name", verb, *_enough(verb, ""))
        yield of(f"{verb} of a folder", verb, *_enough(verb, "."))
        yield of(f"{verb} of a name too long", verb, *_enough(verb, "n" * 5000))
        yield of(f"{verb} of a name with an escape", verb, *_enough(verb, "\x1b]0;x\x07"))
        yield of(f"{verb} of a name with lines", verb, *_enough(verb, "a\nbilayer: error: b\n"))


NEED_NOTHING = ("init", "demo", "settings")
"""Verbs that do something when they are given no word."""


def _enough(verb: str, name: str) -> tuple[str, ...]:
    """Return the words that a verb needs, its input being of a name."""
    return {
        "init": ("--set", name),
        "mesh": (name, "-o", "m.vtu"),
        "solve": (name, "--solver", "dshell", "-o", "a.nc"),
        "compare": (name, name),
        "plot": (name, "-o", "a.png"),
        "convert": (name, "-o", "a.vtu"),
        "export": (name, "-o", "a.inp"),
        "import": (name, name, "-o", "a.nc"),
        "info": (name,),
        "study": (name, "-o", "st"),
        "plot-study": (name, "--x", "cut.strips", "-o", "a.png"),
        "rerun": (name,),
        "cut": (name, "-o", "a.dxf"),
        "fit": (name,),
        "view": (name, "--no-open"),
        "animate": (name, "-o", "a.gif"),
        "barrier": (name, "1", "2", "-o", "a.nc"),
        "demo": ("-o", f"none/{name}"),
        "design": (name, "-o", "out"),
        "settings": (name,),
        "states": (name, "-o", "a.nc"),
    }.get(verb, (name, "-o", "a.x"))


def _study_options(bench: Any) -> Iterator[Attempt]:
    files = {"w": bench.study}

    def of(name: str, *words: str, right: Right = Right.REFUSED, **more: Any) -> Attempt:
        outputs = ("w/st/study.csv", "w/st/plan.json", "w/st/.lock", "w/st/.workers")
        return Attempt("options", name, words, files, right, outputs, **more)

    study = ("study", "w/study.toml", "-o", "w/st", "--quiet")
    for value in NO_COUNTS:
        for option in ("--jobs", "--case", "--ranks-per-case"):
            right = Right.REFUSED
            if option != "--case" and value in ("1e300", "1e30"):
                right = Right.EITHER  # as many as there are
            yield of(
                f"study {option} {value[:9]}", *study, f"{option}={value}", says=option, right=right
            )
    yield of("study --case 3 of 2", *study, "--case", "3", says="case")
    yield of("study --case --dry-run", *study, "--case", "1", "--dry-run")
    draw = ("plot-study", "w/st", "-o", "a.png")
    for x in ("", "x", "cut", "cut.strips", "case", "\x1b[31m", "position", "__class__"):
        yield of(f"plot-study --x {x!r}", *draw, f"--x={x}")
    for y in ("", "x", "position", "face_nodes", "versions", "\x1b[31m", "node"):
        yield of(f"plot-study --y {y!r}", *draw, "--x", "cut.cutout_angle", f"--y={y}")
    for hue in ("", "x", "cut", "position", "case"):
        yield of(f"plot-study --hue {hue!r}", *draw, "--x", "cut.cutout_angle", f"--hue={hue}")
    for value in (
        "",
        "x",
        "=",
        "a=",
        "=1",
        "cut.cutout_angle",
        "cut.cutout_angle=5",
        "cut.cutout_angle=x",
        "cut.cutout_angle=[]",
        "cut.cutout_angle=" + "9" * 400,
        "quality=1",
        "prestretch={}",
        "prestretch=1979-05-27",
        "case=1",
        "solver=dshell",
    ):
        right = Right.EITHER if value == "solver=dshell" else Right.REFUSED
        yield Attempt(
            "options",
            f"plot-study --select {value[:24]!r}",
            (*draw, "--x", "prestretch", f"--select={value}"),
            files,
            right,
            ("a.png",),
        )
    for value in NO_NUMBERS:
        yield of(
            f"plot-study --prestretch {value[:9]}",
            *draw,
            "--x",
            "cut.cutout_angle",
            f"--prestretch={value}",
        )
    yield of("good: study again", *study, right=Right.ACCEPTED)
    yield of("good: study --dry-run", *study, "--dry-run", right=Right.ACCEPTED)
    yield Attempt(
        "options",
        "good: plot-study",
        (*draw, "--x", "cut.cutout_angle", "--prestretch", "1.001"),
        files,
        Right.ACCEPTED,
        ("a.png",),
        ("a.png",),
    )
