"""Texts in files and names that mean something elsewhere: to a terminal, to TeX, to a reader."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from attack.attempt import Attempt, Right
from attack.result_structure import Content
from attack.specimen_files import SHORT
from attack.toml_text import document

FAKE = "x\nTo run it again, with the versions above:\n  rm -rf ~"
ODD = {
    "an escape": "\x1b[31mred\x1b]0;title\x07",
    "a carriage return": "good\rbad",
    "lines of its own": FAKE,
    "a bell": "\x07",
    "backspaces": "bad\b\b\bgood",
    "control of 8 bits": "\x9b31m",
    "turned letters": "\u202egnp.exe",
    "TeX": r"$\frac{$",
    "a dollar": "5 $",
    "two dollars": "$x$ and $\\alpha",
    "percent": "%s%n{0}",
    "no ASCII": "Größe ≤ 日本",
    "long": "n" * 20_000,
    "empty": "",
    "a script": "</title></script><script>stolen()</script>",
    "an image that runs": "<img src=x onerror=stolen()>",
    "quotes": "'\"`$(touch canary)",
}
CONTROL = r"[\x00-\x08\x0b-\x1f\x7f\x80-\x9f\u202e]"
VIEW = ("view", "r.nc", "-o", "a.html", "--no-open")
FORGED = r"(?m:^(To run it again, with the versions above:\n  rm|  rm -rf))"


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    for attribute in (
        "versions",
        "git_commit",
        "stop_reason",
        "model",
        "start",
        "not_measured",
        "reference_surface",
        "settings",
        "specimen",
    ):
        for name, text in ODD.items():
            for words in (
                ("info", "r.nc"),
                ("plot", "r.nc", "-o", "a.png"),
                ("compare", "r.nc", "good.nc"),
                VIEW,
            ):
                if words[0] != "info" and attribute not in ("model", "stop_reason", "versions"):
                    continue
                yield _of_attribute(bench, attribute, name, text, words)
    for name, text in ODD.items():
        tables = {**SHORT, "specimen": {**SHORT["specimen"], "name": text}}
        file = {"s.toml": document(tables)}
        solve = ("solve", "s.toml", "--solver", "dshell", "-o", "a.nc", "--quiet")
        yield Attempt(
            "text", f"specimen.name: {name}", solve, file, Right.EITHER, ("a.nc",), says_not=CONTROL
        )

        def named(path: Path, text: str = text) -> None:
            content = Content(bench.result)
            content.attrs["specimen"] = document(
                {**SHORT, "specimen": {**SHORT["specimen"], "name": text}}
            )
            content.write(path)

        for words, outputs in (
            (("info", "r.nc"), ()),
            (VIEW, ("a.html",)),
            (("plot", "r.nc", "-o", "a.png"), ("a.png",)),
            (("mesh", "s.toml", "-o", "m.vtu"), ("m.*",)),
        ):
            files = {"r.nc": named, **file}
            yield _shown(f"{words[0]}: specimen.name is {name}", words, files, outputs)
    for name in (
        "$x$",
        "$\\frac{",
        "a b",
        "日本",
        "-a",
        "--quiet",
        "a;b",
        "a'b",
        "%s",
        "{0}",
        "a" * 200,
    ):
        file = f"{name}.nc"
        path = f"./{file}" if name.startswith("-") else file
        for words, outputs in (
            (("info", path), ()),
            (("plot", path, "-o", "a.png"), ("a.png",)),
            (("view", path, "-o", "a.html", "--no-open"), ("a.html",)),
            (("compare", path, "good.nc", "-o", "a.png"), ("a.png",)),
            (("rerun", path, "--quiet"), ()),
        ):
            yield Attempt(
                "text",
                f"{words[0]} of {file[:20]}",
                words,
                {file: bench.result, "good.nc": bench.result},
                Right.ACCEPTED,
                outputs,
                outputs,
            )


def _of_attribute(
    bench: Any, attribute: str, name: str, text: str, words: tuple[str, ...]
) -> Attempt:
    def make(path: Path) -> None:
        content = Content(bench.result)
        content.attrs[attribute] = text
        content.write(path)

    files = {"r.nc": make, "good.nc": bench.result}
    outputs = {"plot": ("a.png",), "view": ("a.html",)}.get(words[0], ())
    return _shown(f"{words[0]}: {attribute} is {name}", words, files, outputs)


def _shown(
    name: str, words: tuple[str, ...], files: dict[str, Any], outputs: tuple[str, ...]
) -> Attempt:
    """A verb that shows an odd text: neither raw on the terminal nor as markup in a page."""
    return Attempt(
        "text",
        name,
        words,
        files,
        Right.EITHER,
        outputs,
        says_not=f"{CONTROL}|{FORGED}",
        check=_runs_nothing if words is VIEW else None,
    )


def _runs_nothing(folder: Path, said: str) -> str:
    """Return a complaint if a page holds markup that came from a result."""
    page = (folder / "a.html").read_text(encoding="utf-8")
    markup = ("<script>stolen()", "<img src=x", "</title></script><")
    return next((f"the page holds {part!r}" for part in markup if part in page), "")
