"""What CalculiX writes, as other systems write it, and damaged."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from attack.attempt import Attempt, Right
from attack.values import NO_FILES
from bilayer import open_result
from bilayer.geometry.alignment import rms_distance

STA = "     1          1     1     6  0.100000E+01  0.100000E+01  0.100000E+01\n"
CVG = "     1     1     1     1        0  0.1000E-01  0.1000E+00  0.0000E+00  0.0000E+00\n"
WORDS = ("import", "deck.frd", "uncut.toml", "--prestretch", "1.03", "-o", "a.nc", "--quiet")
Style = Callable[[float], str]


def write_run(deck: Path, name: Path, style: Style | None = None) -> None:
    """Write the files of a run of a deck, with displacements of our own."""
    number = style or plain
    nodes = _nodes(deck)
    moved = [(n, -1e-3 * x, 1e-3 * y, 2e-3 * (x * x + y * y)) for n, x, y, _ in nodes]
    lines = [
        "    1C",
        "    1UVERSION           Version 2.20",
        f"    2C{len(nodes):30d}{1:38d}",
        *_rows(nodes, number),
        " -3",
        "    1PSTEP                         1           1           1",
        "  100CL  101 1.000000000",
        " -4  DISP        4    1",
        *_rows(moved, number),
        " -3",
        " 9999",
        "",
    ]
    name.with_suffix(".frd").write_text("\n".join(lines), encoding="latin-1")
    name.with_suffix(".sta").write_text(STA, encoding="latin-1")
    name.with_suffix(".cvg").write_text(CVG, encoding="latin-1")


def plain(value: float) -> str:
    """Return a number as CalculiX writes it on Linux."""
    return f"{value:12.5E}"


def three_digits(value: float) -> str:
    """Return one as CalculiX writes it on Windows: 13 columns where it is negative."""
    return re.sub(r"E([+-])(\d\d)$", r"E\g<1>0\2", plain(value)).strip().rjust(12)


def _nodes(deck: Path) -> list[tuple[int, float, float, float]]:
    found, on = [], False
    for line in deck.read_text(encoding="utf-8").splitlines():
        if line.startswith("*"):
            on = line.upper().startswith("*NODE,") and "CONTROL" not in line.upper()
        elif on:
            n, x, y, z = (float(word) for word in line.split(","))
            found.append((int(n), x, y, z))
    return sorted(found)


def _rows(values: Any, number: Style) -> list[str]:
    return [f" -1{n:10d}" + "".join(map(number, numbers)) for n, *numbers in values]


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    whole = (bench.deck / "deck.frd").read_text(encoding="latin-1")
    lines = whole.split("\n")

    def of(
        name: str,
        frd: Any,
        right: Right = Right.REFUSED,
        says: str = "deck",
        sta: Any = STA,
        cvg: Any = CVG,
        words: tuple[str, ...] = WORDS,
        check: Any = None,
    ) -> Attempt:
        files = {"uncut.toml": bench.uncut, "deck.frd": frd, "deck.sta": sta, "deck.cvg": cvg}
        present = {k: v for k, v in files.items() if v is not None}
        return Attempt(
            "frd file",
            name,
            words,
            present,
            right,
            ("a.nc",),
            says=says if right is Right.REFUSED else "",
            check=check,
        )

    same = _same_shape(bench)
    for name, style in {
        "as it is": plain,
        "exponents of three digits": three_digits,
        "commas": lambda v: plain(v).replace(".", ","),
        "three digits and commas": lambda v: three_digits(v).replace(".", ","),
        "exponents with D": lambda v: plain(v).replace("E", "D"),
        "small letters": lambda v: plain(v).lower(),
    }.items():

        def make(path: Path, style: Style = style) -> None:
            write_run(bench.deck / "deck.inp", path.with_suffix(""), style)
            path.with_suffix(".sta").unlink()
            path.with_suffix(".cvg").unlink()

        right = Right.EITHER if name in ("exponents with D", "small letters") else Right.ACCEPTED
        yield of(f"good: {name}", make, right, check=same)
    yield of("good: CRLF", whole.replace("\n", "\r\n"), Right.ACCEPTED, check=same)
    yield of("good: blanks at the end", re.sub("\n", "   \n", whole), Right.ACCEPTED, check=same)
    yield of(
        "good: .sta and .cvg with CRLF",
        whole,
        Right.ACCEPTED,
        check=same,
        sta=STA.replace("\n", "\r\n"),
        cvg=CVG.replace("\n", "\r\n"),
    )
    for number in range(30):
        end = chance.randrange(1, len(whole) - 10)
        yield of(f"cut off {number}", whole[:end], Right.HANDLED, check=same)
    for number in range(30):
        yield of(f"a line is gone {number}", "\n".join(_without(lines, chance)), Right.HANDLED)
    for number in range(60):
        yield of(f"changed {number}", _changed(whole, chance), Right.HANDLED)
    for word in ("nan", "inf", "-inf", "******", "1e999", "", "x", "1.0.0", "--1", "1E", "0x10"):
        damaged = _put_number(lines, word, 10 + chance.randrange(20))
        yield of(f"a coordinate is {word!r}", damaged)
        diverged = Right.HANDLED if "n" in word else Right.REFUSED  # as a run that did not converge
        yield of(f"a displacement is {word!r}", _put_number(lines, word, len(lines) - 12), diverged)
    for name, content in {
        "empty": "",
        "blank": "\n\n",
        "a text": "hello\n",
        "binary": bytes(range(256)) * 20,
        "no nodes": "\n".join(line for line in lines if not line.startswith(" -1")),
        "no displacements": whole.replace("DISP", "STRESS"),
        "only its end": " 9999\n",
        "a deck": (bench.deck / "deck.inp").read_text(encoding="utf-8"),
        "binary format of CalculiX": whole.replace("    2C", "    2C")
        .replace("                1\n", "                2\n")
        .encode("latin-1")
        + bytes(500),
    }.items():
        right = (
            Right.HANDLED
            if name in ("no displacements", "binary format of CalculiX")
            else Right.REFUSED
        )
        yield of(name, content, right)
    yield of("a node twice", whole.replace(" -1         2", " -1         1", 1))
    yield of("nodes in another order", _turned_about(lines), Right.EITHER, check=same)
    yield of(
        "fewer nodes", "\n".join(line for line in lines if not line.startswith(" -1         9"))
    )
    yield of("a node of 1e9", whole.replace(" -1         9", " -1999999999"))
    yield of("a node below 0", whole.replace(" -1         9", " -1        -9"))
    yield of("a node of letters", whole.replace(" -1         9", " -1         x"))
    for ending, good in (("sta", STA), ("cvg", CVG)):
        for name, content in {
            "missing": None,
            "empty": "",
            "a text": "hello\n",
            "cut off": good[:30],
            "more columns": good.rstrip() + " 1 2 3\n",
            "letters": good.replace("0.1", "x.1"),
            "nan": good.replace("0.100000E+01", "nan").replace("0.1000E-01", "nan"),
            "binary": bytes(range(256)),
        }.items():
            right = (
                Right.HANDLED
                if name in ("nan",) or (ending == "cvg" and name == "letters")
                else Right.REFUSED
            )
            if name in ("empty", "a text", "binary"):
                right = Right.HANDLED
            yield of(f".{ending} {name}", whole, right, **{ending: content})
    yield of(
        "good: gave up half way",
        whole,
        Right.HANDLED,
        sta=STA + "     1          2    1U    6  0.500000E+00  0.500000E+00  0.500000E+00\n",
    )
    yield of("twice the same", whole, words=(*WORDS[:2], "deck.frd", *WORDS[2:]), says="frd")
    yield of("another mesh size", whole, words=(*WORDS, "--mesh-size", "0.03"))
    yield of("another specimen", whole, words=(*WORDS, "--set", "substrate.thickness=0.003"))
    yield of("no such prestretch", whole, words=(*WORDS[:4], "1.5", *WORDS[5:]))
    for name, make in NO_FILES.items():
        yield of(name, make)
        yield of(f".sta is {name}", whole, sta=make)


def _same_shape(bench: Any) -> Callable[[Path, str], str]:
    """Return a check that the shape is the one that was written, to its six digits."""

    def check(folder: Path, said: str) -> str:
        nodes = np.array(_nodes(bench.deck / "deck.inp"))
        result = open_result(folder / "a.nc")
        if not result["converged"].values.all():
            return ""
        position = result["position"].values[0]
        x, y, z = 1e-3 * nodes[: len(position), 1:].T
        right = np.column_stack([x - 1e-3 * x, y + 1e-3 * y, z + 2.0 * (x * x + y * y)])
        distance = rms_distance(position, right, np.ones(len(right)))
        return "" if distance < 1e-6 else f"the shape is {distance:.3g} m off"

    return check


def _without(lines: list[str], chance: random.Random) -> list[str]:
    at = chance.randrange(len(lines) - 1)
    return lines[:at] + lines[at + 1 :]


def _changed(text: str, chance: random.Random) -> str:
    for _ in range(chance.choice((1, 1, 4))):
        at = chance.randrange(len(text))
        text = text[:at] + chance.choice("0123456789.-+eE \n,x\0") + text[at + 1 :]
    return text


def _put_number(lines: list[str], word: str, at: int) -> str:
    changed = list(lines)
    while not changed[at].startswith(" -1"):
        at -= 1
    row = changed[at]
    changed[at] = row[:13] + word.rjust(12) + row[25:]
    return "\n".join(changed)


def _turned_about(lines: list[str]) -> str:
    first = next(k for k, line in enumerate(lines) if line.startswith(" -1"))
    last = next(k for k in range(first, len(lines)) if not lines[k].startswith(" -1"))
    return "\n".join([*lines[:first], *lines[first:last][::-1], *lines[last:]])
