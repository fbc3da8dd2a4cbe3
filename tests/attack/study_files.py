"""Study files: every key with what it does not take; too many cases; cases that are not valid."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

from attack.attempt import Attempt, Right
from attack.toml_text import Raw, document
from attack.values import HUGE, NO_NUMBER

BASE: dict[str, Any] = {
    "specimen": "s.toml",
    "solver": "dshell",
    "settings": {"dshell": {"model": "paper", "total_time": 0.002}},
    "vary": {"cut.cutout_angle": [0.3, 0.4]},
}
DRY = ("study", "study.toml", "-o", "st", "--dry-run", "--quiet")
START = ("study", "study.toml", "-o", "st", "--quiet", "--case", "1")
ODD: dict[str, Any] = {**NO_NUMBER, "number": 5, "minus": -1, "unknown": "unknown"}
RANGE = {"start": 0.2, "stop": 0.6, "num": 3}


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    def of(name: str, text: str | bytes, right: Right = Right.REFUSED, says: str = "") -> Attempt:
        words = chance.choice((DRY, START)) if right is Right.REFUSED else DRY
        return Attempt(
            "study file",
            name,
            words,
            {"s.toml": bench.specimen, "study.toml": text},
            right,
            says=says,
        )

    def put(name: str, right: Right = Right.REFUSED, says: str = "", **keys: Any) -> Attempt:
        tables = {**BASE, **keys}
        return of(name, document({k: v for k, v in tables.items() if v is not None}), right, says)

    def sampled(name: str, right: Right = Right.REFUSED, **keys: Any) -> Attempt:
        good = {"n": 4, "seed": 1, "substrate.young_modulus": {"low": 1.1e5, "high": 1.2e5}}
        content = {k: v for k, v in {**good, **keys}.items() if v is not None}
        return put(f"sample {name}", right, vary={}, sample=content)

    yield put("good: as it is", Right.ACCEPTED)
    for key in BASE:
        for label, value in ODD.items():
            if label in ("table", "empty table") and key in ("settings", "vary"):
                continue
            yield put(f"{key}: {label}", says=rf"{key}|nested|TOML", **{key: value})
    for key in ("specimen", "solver"):
        yield put(f"{key} is missing", says=key, **{key: None})
    for label, value in ODD.items():
        if label in ("list",):
            continue
        yield put(
            f"values of a field: {label}",
            vary={"cut.cutout_angle": value},
            says="cutout_angle|nested",
        )
        yield put(f"a value of a field: {label}", vary={"cut.cutout_angle": [0.3, value]})
        if label != "number":
            yield put(
                f"a value of a setting: {label}", vary={"settings.dshell.total_time": [value]}
            )
        for name in RANGE:
            if label == "number" or (name != "num" and label == "minus"):
                continue
            yield put(f"range: {name} {label}", vary={"cut.cutout_angle": {**RANGE, name: value}})
        for name in ("n", "seed"):
            if label == "number":
                continue
            yield sampled(f"{name}: {label}", **{name: value})
        if label not in ("number", "minus"):
            low = {"low": value, "high": 1e6}
            yield sampled(f"low: {label}", **{"substrate.young_modulus": low})
        yield sampled(f"limits: {label}", **{"substrate.young_modulus": value})
    for field in (
        "",
        ".",
        "cut",
        "cut.",
        "cut.x",
        ".strips",
        "x.y",
        "cut.strips.x",
        "solver.ramp",
        "settings",
        "settings.dshell",
        "settings.dshell.",
        "settings.dshell.x",
        "settings.fenics.flow_steps",
        "settings.x.y",
        "specimen.nme",
        "\x1b[31m.x",
        "layers.substrate.thickness",
        "a" * 10_000,
        "mesh",
        "solver",
    ):
        yield put(f"field {field[:24]!r}", vary={field: [1]})
        yield put(f"zip of {field[:24]!r}", vary={}, zip={field: [1]})
    million = list(range(1, 1001))
    for name, keys in {
        "a range of 1e30": {"vary": {"cut.cutout_angle": {**RANGE, "num": 1e30}}},
        "a range of 1e9": {"vary": {"cut.cutout_angle": {**RANGE, "num": 10**9}}},
        "a product of 1e9": {
            "vary": {"cut.cutout_angle": million, "cut.inner_radius": million, "mesh.size": million}
        },
        "a product of two ranges of 1e5": {
            "vary": {
                "cut.cutout_angle": {**RANGE, "num": 10**5},
                "cut.inner_radius": {**RANGE, "num": 10**5},
            }
        },
        "a range of 400 digits": {"vary": {"cut.cutout_angle": {**RANGE, "num": HUGE}}},
        "a range from 400 digits": {"vary": {"cut.cutout_angle": {**RANGE, "start": HUGE}}},
        "twelve fields of ten": {
            "vary": {f"settings.dshell.x{k}": list(range(10)) for k in range(12)}
        },
    }.items():
        yield put(f"too many: {name}", **keys)
    yield sampled("n of 1e30", n=10**30)
    yield sampled("n of 1e12", n=10**12)
    yield sampled("seed of 400 digits", Right.EITHER, seed=HUGE)
    yield sampled("seed of 30 digits", Right.EITHER, seed=10**30)
    yield sampled("of nothing", **{"substrate.young_modulus": None})
    yield sampled("without n", n=None)
    yield sampled("without seed", seed=None)
    yield sampled("high below low", **{"substrate.young_modulus": {"low": 2.0, "high": 1.0}})
    yield sampled("low is high", **{"substrate.young_modulus": {"low": 2.0, "high": 2.0}})
    yield sampled("a third limit", **{"substrate.young_modulus": {"low": 1e5, "high": 2e5, "x": 1}})
    yield sampled("good", Right.ACCEPTED)
    yield put("a range without stop", vary={"cut.cutout_angle": {"start": 0.1, "num": 2}})
    yield put("a range of more", vary={"cut.cutout_angle": {**RANGE, "step": 1}})
    yield put("zip of two lengths", vary={}, zip={"cut.strips": [4, 5], "cut.cutout_angle": [0.1]})
    yield put("a field in two tables", zip={"cut.cutout_angle": [0.1, 0.2]})
    yield put("an empty list", vary={"cut.strips": []}, says="strips")
    yield put("unknown key", says="varry", varry={})
    yield put("settings of another solver", settings={"fenics": {}}, says="fenics")
    yield put("settings of no solver", settings={"x": {}})
    yield put("settings are a number", settings={"dshell": 5})
    yield put("an unknown setting", settings={"dshell": {"model": "paper", "frobnicate": 1}})
    yield put("an unknown model", settings={"dshell": {"model": "x"}})
    yield put("a model that is a list", settings={"dshell": {"model": []}})
    yield put("a setting out of range", settings={"dshell": {"model": "paper", "total_time": -1}})
    yield put("no solver", solver=[])
    yield put("a list of solvers in a list", solver=[["dshell"]])
    yield put("one solver of two unknown", solver=["dshell", "abaqus"], says="abaqus")
    for name, value in {
        "none": "none.toml",
        "empty": "",
        "a folder": ".",
        "itself": "study.toml",
        "NUL": "s\0.toml",
        "a device": "/dev/null",
        "too long": "n" * 5000,
        "an URL": "https://127.0.0.1:9/s.toml",
        "an escape": "\x1b[31m.toml",
        "a home": "~/s.toml",
        "memory": "/proc/self/mem",
    }.items():
        yield put(f"specimen: {name}", specimen=value)
    yield put("all cases invalid", vary={"cut.strips": [0, -1, "x"]}, says="strips")
    yield put("one case of many invalid", vary={"cut.cutout_angle": [0.3, 0.4, 7.0]}, says="7.0")
    yield put("milestones that are texts", vary={"prestretch.milestones": ["x", "y"]})
    yield put("milestones of lists of lists", vary={"prestretch.milestones": [[[1.03]]]})
    yield put("milestones mixed", vary={"prestretch.milestones": [1.03, [1.02, 1.01], "x"]})
    yield put("milestones that are dates", vary={"prestretch.milestones": [Raw("1979-05-27")]})
    yield put(
        "good: milestones and pairs",
        Right.ACCEPTED,
        vary={"prestretch.milestones": [1.03, [1.02, 1.01]]},
    )
    yield put("good: texts with units", Right.ACCEPTED, vary={"mesh.size": ["20 mm", "2 cm"]})
    yield put("good: names", Right.ACCEPTED, vary={"specimen.name": ["a", "b"]})
    yield put("good: both solvers", Right.EITHER, solver=["dshell", "fenics"], settings={})
    yield put(
        "good: a thousand cases", Right.ACCEPTED, vary={"cut.cutout_angle": {**RANGE, "num": 1000}}
    )
    good = document(BASE)
    for name, content in {
        "empty": b"",
        "zeros": bytes(100),
        "UTF-16": good.encode("utf-16"),
        "Latin-1": good.encode() + b"# \xe9\n",
        "deep": b"vary = " + b"[" * 5000,
        "deep tables": b"vary = " + b"{a=" * 5000 + b"1" + b"}" * 5000,
        "NUL": good.encode() + b"\0",
        "JSON": b'{"specimen": "s.toml"}',
        "5000 digits": b"solver = " + b"9" * 5000,
    }.items():
        yield of(f"text: {name}", content)
    for number in range(20):
        yield of(f"text: cut off {number}", good[: chance.randrange(len(good) - 2)], Right.EITHER)
    for number in range(40):
        from attack.specimen_files import changed_text

        yield of(f"text: changed {number}", changed_text(good, chance), Right.EITHER)
    for name, target in {
        "empty": "",
        "the study file": "study.toml",
        "the specimen": "s.toml",
        "in a file": "s.toml/st",
        "a device": "/dev/null",
        "NUL device in it": "/dev/null/st",
        "too long": "n" * 5000,
        "a folder of the system": "/proc/st",
        "the root": "/proc",
    }.items():
        for last in ((), ("--case", "1"), ("--dry-run",)):
            right = (
                Right.EITHER if last == ("--dry-run",) else Right.REFUSED
            )  # which writes nothing
            yield Attempt(
                "study file",
                f"-o {name} {' '.join(last)}".strip(),
                ("study", "study.toml", f"--output={target}", "--quiet", *last),
                {"s.toml": bench.specimen, "study.toml": good},
                right,
            )
