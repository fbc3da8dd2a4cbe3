"""Folders of a finished study in which one file is damaged, gone, or of another kind."""

from __future__ import annotations

import json
import os
import random
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from attack.attempt import Attempt, Right

CASE = ("study", "w/study.toml", "-o", "w/st", "--quiet", "--case", "1")
WHOLE = ("study", "w/study.toml", "-o", "w/st", "--quiet")
DRY = (*WHOLE, "--dry-run")
DRAW = ("plot-study", "w/st", "--x", "cut.cutout_angle", "--prestretch", "1.001", "-o", "a.png")
TEXTS: dict[str, bytes] = {
    "empty": b"",
    "blank": b"\n",
    "a list": b"[]",
    "a table": b"{}",
    "a number": b"5",
    "null": b"null",
    "a text": b'"x"',
    "cut off": b'{"status": "fail',
    "zeros": bytes(64),
    "binary": bytes(range(256)),
    "deep": b"[" * 100_000,
    "UTF-16": '{"status": "failed"}'.encode("utf-16"),
    "400 digits": b'{"status": ' + b"9" * 5000 + b"}",
    "fields of numbers": b'{"status": 5, "reason": 5, "fields": 5, "cases": 5}',
    "fields of null": b'{"status": null, "reason": null, "fields": null, "cases": null}',
    "fields of lists": b'{"status": [], "reason": [], "fields": [], "cases": [[]]}',
    "cases of numbers": b'{"fields": [], "cases": [1, 2]}',
    "cases of empty tables": b'{"fields": ["x"], "cases": [{}]}',
}
Damage = Callable[[Path], Any]


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    first, second = cases(bench)
    for name, damage in _damages(bench, first, second).items():
        yield _computed_anew(bench, f"{name}, its case", CASE, damage, first)
        if not name.startswith(("result", "unfinished")):
            yield _computed_anew(bench, f"{name}, all", WHOLE, damage, first)
        yield _attempt(bench, f"{name}, --dry-run", DRY, damage, Right.EITHER)
        yield _attempt(bench, f"{name}, plot-study", DRAW, damage, Right.HANDLED)
    for name, damage in _kinds(first).items():
        yield _attempt(bench, f"{name}, its case", CASE, damage, Right.HANDLED)
        yield _attempt(bench, f"{name}, all", WHOLE, damage, Right.HANDLED)
        yield _attempt(bench, f"{name}, plot-study", DRAW, damage, Right.HANDLED)
    for name, damage in {
        "the index is gone": lambda st: (st / "study.csv").unlink(missing_ok=True),
        "the index is a text": lambda st: (st / "study.csv").write_bytes(b"x"),
        "the log is gone": lambda st: (st / "study.log").unlink(),
        "the log is binary": lambda st: (st / "study.log").write_bytes(bytes(range(256)) * 9),
        "the log is cut off": lambda st: (st / "study.log").write_bytes(b"2020\tbegun"),
        "the plan is gone": lambda st: (st / "plan.json").unlink(),
        "a file of one's own": lambda st: (st / "notes.txt").write_bytes(b"x"),
        "a file of one's own among the cases": lambda st: (st / "cases/x.nc").write_bytes(b"x"),
        "a folder of one's own among the cases": lambda st: (st / "cases/x").mkdir(),
        "all is gone": lambda st: shutil.rmtree(st),
    }.items():
        yield _computed_anew(bench, f"{name}, its case", CASE, damage, first)


def cases(bench: Any) -> list[str]:
    """Return the hashes of the study's two cases, in their order."""
    plan = json.loads((bench.study / "st" / "plan.json").read_text(encoding="utf-8"))
    return [entry["case"] for entry in plan["cases"]]


def _attempt(
    bench: Any, name: str, words: tuple[str, ...], damage: Damage, right: Right, check: Any = None
) -> Attempt:
    def make(path: Path) -> None:
        shutil.copytree(bench.study, path)
        damage(path / "st")

    outputs = ("w/st/*", "w/st", "a.png")
    if words is DRY:
        outputs = ()
    if words is DRAW:
        outputs = ("a.png",)
    return Attempt("study folder", name, words, {"w": make}, right, outputs, check=check)


def _computed_anew(
    bench: Any, name: str, words: tuple[str, ...], damage: Damage, case: str
) -> Attempt:
    """Return an attempt after which the case is there, whole, and nothing is half written."""

    def check(folder: Path, said: str) -> str:
        from bilayer import open_result
        from bilayer.errors import InputError

        try:
            result = open_result(folder / "w/st/cases" / f"{case}.nc")
        except InputError as error:
            return f"the case is not there: {error}"
        if result.attrs.get("study_case") != case:
            return "the result is of another case"
        left = [
            p.name for p in (folder / "w/st").rglob(".*") if p.name not in (".lock", ".workers")
        ]
        return f"{left[0]} is left behind" if left else ""

    return _attempt(bench, name, words, damage, Right.ACCEPTED, check)


def _damages(bench: Any, first: str, second: str) -> dict[str, Damage]:
    """Return what may happen to the files of the first case, and to the plan."""
    made: dict[str, Damage] = {}
    whole = (bench.study / "st/cases" / f"{first}.nc").read_bytes()
    other = (bench.study / "st/cases" / f"{second}.nc").read_bytes()

    def write(name: str, content: bytes, instead: bool = False) -> Damage:
        def damage(st: Path) -> None:
            if instead:
                (st / f"cases/{first}.nc").unlink()
            (st / name).write_bytes(content)

        return damage

    for label, content in TEXTS.items():
        made[f"failed: {label}"] = write(f"cases/{first}.failed", content, instead=True)
        made[f"plan: {label}"] = write("plan.json", content)
        made[f"result: {label}"] = write(f"cases/{first}.nc", content)
        made[f"unfinished: {label}"] = write(f"cases/{first}.unfinished.nc", content, instead=True)
    for share in (0.1, 0.5, 0.9, 0.999):
        cut = whole[: int(share * len(whole))]
        made[f"result: {share} of it"] = write(f"cases/{first}.nc", cut)
        made[f"unfinished: {share} of it"] = write(f"cases/{first}.unfinished.nc", cut, True)
    made["result: of the other case"] = write(f"cases/{first}.nc", other)
    made["unfinished: of the other case"] = write(f"cases/{first}.unfinished.nc", other, True)
    made["unfinished: a whole result"] = write(f"cases/{first}.unfinished.nc", whole, True)
    for attribute in ("stop_reason", "specimen", "versions", "study_case", "study_case_seconds"):
        made[f"result: without {attribute}"] = _without_attribute(first, attribute)
    for variable in ("converged", "wall_time", "quality", "position"):
        made[f"result: without {variable}"] = _without_variable(first, variable)
    return made


def _without_attribute(case: str, attribute: str) -> Damage:
    def damage(st: Path) -> None:
        import netCDF4

        with netCDF4.Dataset(st / f"cases/{case}.nc", "a") as stored:
            stored.delncattr(attribute)

    return damage


def _without_variable(case: str, variable: str) -> Damage:
    def damage(st: Path) -> None:
        import netCDF4

        with netCDF4.Dataset(st / f"cases/{case}.nc", "a") as stored:
            stored.renameVariable(variable, f"{variable}_of_old")

    return damage


def _kinds(first: str) -> dict[str, Damage]:
    """Return files that are something else: a folder, a pipe, a link to nothing or to a device."""
    names = {
        "the plan": "plan.json",
        "the result": f"cases/{first}.nc",
        "the log": "study.log",
        "the index": "study.csv",
        "the failure": f"cases/{first}.failed",
        "the unfinished result": f"cases/{first}.unfinished.nc",
        "the cases": "cases",
        "the lock": ".lock",
        "the mark of the workers": ".workers",
    }

    def is_now(name: str, make: Callable[[Path], Any]) -> Damage:
        def damage(st: Path) -> None:
            path = st / name
            if "failed" in name or "unfinished" in name:
                (st / f"cases/{first}.nc").unlink()
            if path.is_dir():
                shutil.rmtree(path)
            path.unlink(missing_ok=True)
            make(path)

        return damage

    return {
        f"{what} is {how}": is_now(name, make)
        for what, name in names.items()
        for how, make in {
            "a folder": lambda path: (path / "x").mkdir(parents=True),
            "a pipe": os.mkfifo,
            "a link to nothing": lambda path: path.symlink_to("/nowhere/x"),
            "a link to itself": lambda path: path.symlink_to(path.name),
        }.items()
        if not (what == "the cases" and how == "a folder")
    }
