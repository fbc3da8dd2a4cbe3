"""Design files: each key with what it does not take, targets of all kinds, damaged ones."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from typing import Any

from attack.attempt import Attempt, Right
from attack.specimen_files import Path_, changed
from attack.toml_text import document
from attack.values import (
    HUGE,
    NO_ANGLE,
    NO_CHOICE,
    NO_COUNT,
    NO_FILES,
    NO_LENGTH,
    NO_LENGTH_OR_ZERO,
    NO_NUMBER,
    NOT_POSITIVE,
)

DESIGN = ("design", "d.toml", "-o", "out", "--quiet")
SHEET: dict[str, Any] = {
    "specimen": {"name": "odd", "outer_radius": 0.04},
    "cut": {"strips": 5, "inner_radius": 0.008, "cutout_angle": 0.3},
    "substrate": {"thickness": 0.001, "young_modulus": 116250.0, "poisson_ratio": 0.49},
    "kirigami": {"thickness": 0.001, "young_modulus": 368988.0, "poisson_ratio": 0.49},
    "prestretch": {"milestones": [1.02]},
    "mesh": {"size": 0.02},
}
TASK: dict[str, Any] = {
    "specimen": "s.toml",
    "search": {"evaluations": 1, "radius": 0.05},
    "target": {"shape": "cap", "radius": 0.03, "angle": 1.0},
    "free": {
        "prestretch": [1.01, 1.2],
        "kirigami.thickness": [0.0005, 0.005],
        "kirigami.pattern.half_angles": [0.05, 0.5],
    },
    "profile": {"knots": 3},
    "robust": {"of": ["prestretch"], "spread": 0.05, "minimise": "mean"},
    "constraints": {
        "least_web": 0.001,
        "least_slot": 0.001,
        "least_radius": 0.001,
        "least_gap": 0.0,
    },
    "check": {"runs": 0, "mesh_size": 0.01, "step": 0.1},
}
NO_BOUNDS = NO_NUMBER | {
    "one": [1.0],
    "three": [1.0, 2.0, 3.0],
    "turned": [2.0, 1.0],
    "equal": [1.02, 1.02],
    "beside the specimen's": [0.9, 0.95],
    "texts": ["a", "b"],
    "nan in it": [math.nan, 2.0],
    "inf in it": [0.0, math.inf],
    "400 digits in it": [0.0, HUGE],
    "a wrong unit in it": ["0 kg", "1 kg"],
    "below 0": [-1.0, 2.0],
}
FIELDS: dict[Path_, dict[str, Any]] = {
    ("specimen",): NO_CHOICE | {"itself": "d.toml", "above": "../s.toml", "a folder": "."},
    ("target", "shape"): NO_CHOICE,
    ("target", "radius"): NO_LENGTH,
    ("target", "angle"): NO_ANGLE | {"a whole turn": 7.0},
    ("target", "size"): NO_CHOICE,
    ("free", "prestretch"): NO_BOUNDS,
    ("free", "kirigami.thickness"): NO_BOUNDS,
    ("free", "kirigami.pattern.half_angles"): NO_BOUNDS,
    ("profile", "knots"): NO_COUNT | {"one": 1},
    ("robust", "of"): {k: v for k, v in NO_CHOICE.items() if k != "empty list"},
    ("robust", "spread"): NO_NUMBER | {"minus": -0.1, "two": 2.0},
    ("robust", "minimise"): NO_CHOICE,
    ("constraints", "least_web"): NO_LENGTH_OR_ZERO | {"wider than the sheet": 1.0},
    ("constraints", "least_gap"): NO_LENGTH_OR_ZERO,
    ("search", "evaluations"): NO_COUNT,
    ("search", "radius"): NO_NUMBER | NOT_POSITIVE | {"two": 2.0},
    ("search", "settings"): NO_NUMBER
    | {"unknown": {"speed": 3}, "code": {"petsc_options": "-snes_view ascii:x"}},
    ("check", "runs"): NO_COUNT,
    ("check", "mesh_size"): NO_LENGTH,
    ("check", "step"): NO_NUMBER | NOT_POSITIVE,
}
HARMLESS = {("search", "settings"): "empty table", ("check", "runs"): ("zero", "-0.0")}

TETRAHEDRON = "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 2 3\nf 1 2 4\n"
TARGETS: dict[str, dict[str, bytes]] = {
    "t.obj": {
        "empty": b"",
        "no faces": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n",
        "a face of nothing": b"v 0 0 0\nf 1 2 3\n",
        "nan": TETRAHEDRON.replace("10", "nan").encode(),
        "all in one point": TETRAHEDRON.replace("10", "0").encode(),
        "binary": bytes(range(256)) * 9,
    },
    "t.stl": {
        "empty": b"",
        "a head without a body": b"\0" * 84,
        "a count without end": b"\0" * 80 + b"\xff" * 4,
        "text": b"solid x\n",
        "netCDF": b"\x89HDF\r\n\x1a\n" + bytes(90),
    },
    "t.csv": {
        "empty": b"",
        "names alone": b"x,y,z\n",
        "three points": b"x,y,z\n0,0,0\n1,0,0\n0,1,0\n",
        "two columns": b"0,0\n1,0\n0,1\n1,1\n",
        "texts": b"a,b,c\nd,e,f\n",
        "nan": b"0,0,nan\n1,0,0\n0,1,0\n1,1,0\n",
        "on a line": b"0,0,0\n1,0,0\n2,0,0\n3,0,0\n4,0,0\n",
        "one point": b"0,0,0\n" * 20,
        "of 1e300": b"0,0,0\n1e300,0,0\n0,1e300,0\n1e300,1e300,1\n",
        "binary": bytes(range(256)) * 9,
    },
    "t.xlsx": {"of another kind": b"PK\x03\x04"},
    "t": {"without an ending": b"0,0,0\n"},
}


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    for path, values in FIELDS.items():
        for label, value in values.items():
            if label not in HARMLESS.get(path, ()):
                yield refused(f"{'.'.join(path)} {label}", changed(TASK, path, value))
    yield from _keys_and_tables()
    for name, contents in TARGETS.items():
        for label, content in contents.items():
            tables = changed(TASK, ("target",), {"file": name, "unit": "mm"})
            yield refused(f"target {name}: {label}", tables, {name: content})
    for label, make in NO_FILES.items():
        tables = changed(TASK, ("target",), {"file": "t.obj"})
        yield refused(f"target is {label}", tables, {"t.obj": make})
        yield refused(f"specimen is {label}", TASK, {"s.toml": make})
    yield from _by_hand()
    yield from _texts(chance)


def refused(name: str, tables: dict[str, Any], files: dict[str, Any] | None = None) -> Attempt:
    held = {"s.toml": document(SHEET), "d.toml": document(tables), **(files or {})}
    return Attempt("design file", name, DESIGN, held)


def _keys_and_tables() -> Iterator[Attempt]:
    for table, content in TASK.items():
        for label, other in (("a number", 5), ("a text", "x"), ("a list", [1]), ("true", True)):
            if not (table == "specimen" and label == "a text"):
                yield refused(f"[{table}] is {label}", changed(TASK, (table,), other))
        if isinstance(content, dict):
            yield refused(f"unknown key in [{table}]", changed(TASK, (table, "odd"), 1))
    for key in ("specimen", "target", "free"):
        yield refused(f"{key} is missing", {k: v for k, v in TASK.items() if k != key})
    yield refused("an unknown table", {**TASK, "odd": {"x": 1}})


def _by_hand() -> Iterator[Attempt]:
    target = TASK["target"]
    yield refused("nothing is free", {**TASK, "free": {}})
    for name in ("thicknes", "kirigami", "kirigami.", "x.y.z", "", "kirigami.pattern.odd", "mesh"):
        yield refused(f"free: {name!r}", {**TASK, "free": {name: [0.0, 1.0]}})
    yield refused(
        "free: a knot beyond", {**TASK, "free": {"kirigami.pattern.half_angles.9": [0, 1]}}
    )
    yield refused(
        "free: a knot twice",
        {
            **TASK,
            "free": {
                "kirigami.pattern.half_angles": [0.05, 0.5],
                "kirigami.pattern.half_angles.1": [0.05, 0.5],
            },
        },
    )
    yield refused("file and shape", {**TASK, "target": {**target, "file": "t.obj"}})
    yield refused("a target far too small", {**TASK, "target": {**target, "radius": 1e-12}})
    yield refused("a target without end", {**TASK, "target": {**target, "radius": 1e200}})
    yield refused("a cap of no angle", {**TASK, "target": {**target, "angle": 1e-9}})
    for key in ("width", "curvature"):
        yield refused(f"a cap with {key}", {**TASK, "target": {**target, key: 1.0}})
    yield refused("a saddle without its lengths", {**TASK, "target": {"shape": "saddle"}})
    yield refused("robust of the sheet", changed(TASK, ("robust", "of"), ["outline.outer_radius"]))
    yield refused("robust of nothing", changed(TASK, ("robust", "of"), ["glue"]))
    heavy = {**SHEET, "gravity": {"acceleration": 9.81}}
    yield refused("a specimen with weight", TASK, {"s.toml": document(heavy)})
    yield refused("a damaged specimen", TASK, {"s.toml": "[specimen\n"})
    yield refused("no specimen", changed(TASK, ("specimen",), "none.toml"))


def _texts(chance: random.Random) -> Iterator[Attempt]:
    good = document(TASK)
    for label, content in {
        "empty": b"",
        "binary": bytes(range(256)),
        "UTF-16": good.encode("utf-16"),
        "NUL in it": good.encode() + b"\0",
        "JSON": b'{"specimen": "s.toml"}',
    }.items():
        yield refused(f"text: {label}", TASK, {"d.toml": content})
    for number in range(30):
        end = chance.randrange(1, len(good) - 2)
        yield Attempt(
            "design file",
            f"text: cut off {number}",
            DESIGN,
            {"s.toml": document(SHEET), "d.toml": good[:end]},
            Right.HANDLED,
            ("out", "out/*"),
        )
