"""What holds, loads, stops and ages a sheet: supports, loads, obstacles, relaxation and time."""

from __future__ import annotations

import copy
import math
import random
from collections.abc import Iterator
from typing import Any

from attack.attempt import Attempt, Right
from attack.specimen_files import DRY, SMALL, SOLVE, STUDY, Path_, changed
from attack.toml_text import document
from attack.values import EXTREME, HUGE, NO_CHOICE, NO_LENGTH, NO_NUMBER

ARM = [[0.0, -0.02], [0.0, 0.02]]
SHEET: dict[str, Any] = {
    "specimen": {
        "name": "held",
        "outline": {"shape": "rectangle", "width": 0.06, "height": 0.04},
    },
    "layers": [
        {"name": "substrate", "thickness": 0.001, "material": "soft", "response": "path"},
        {"name": "cover", "thickness": 0.001, "material": "soft"},
    ],
    "materials": {"soft": {"young_modulus": 1e5, "poisson_ratio": 0.49, "density": 960.0}},
    "prestretch": {"milestones": [1.001]},
    "mesh": {"size": 0.012},
}
HELD = SHEET | {
    "supports": {
        "left": {"where": {"on": "rim", "x": "<= -0.03"}, "kind": "clamped"},
        "right": {"where": {"on": "rim", "x": ">= 0.03"}, "kind": "clamped", "axes": "yz"},
    },
    "loads": {
        "push": {"where": {"on": "rim", "x": ">= 0.03"}, "force": 1e-5, "direction": "x"},
        "poke": {"where": {"line": ARM}, "displacement": 1e-5},
        "body": {"body_force": 1.0, "direction": [0.0, 0.0, -1.0]},
        "edge": {"where": "rim", "line_force": 1e-5},
    },
}
BLOWN = SHEET | {
    "supports": {"rim": {"kind": "hinged"}},
    "loads": {"blow": {"pressure": 0.01}},
}
STOPPED = SHEET | {
    "obstacles": {
        "table": {"shape": "plane", "point": [0.0, 0.0, -0.005], "normal": [0.0, 0.0, 1.0]},
        "ball": {"shape": "sphere", "centre": [0.02, 0.0, -0.02], "radius": 0.01},
    }
}
AGED = SHEET | {
    "materials": {
        "soft": {
            "young_modulus": 1e5,
            "poisson_ratio": 0.49,
            "relaxation": [[0.3, 1.0], [0.2, 10.0]],
        }
    },
    "time": {"hold": 60.0, "milestones": [0.0, 1.0]},
}
NO_SIZE = {k: v for k, v in NO_NUMBER.items() if k not in ("list", "empty list")}
"""What is no number, and no list of one number either."""
NO_LIST_OF_NUMBERS = {
    "empty list": [],
    "texts in it": ["x"],
    "nan in it": [math.nan],
    "400 digits in it": [HUGE],
    "true in it": [True],
    "table in it": [{"x": 1}],
}
NO_VECTOR = {k: v for k, v in NO_NUMBER.items() if k != "text"} | {
    "zero": [0, 0, 0],
    "two": [1, 0],
    "four": [0, 0, 1, 0],
    "nan in it": [0, 0, math.nan],
    "inf in it": [0, 0, math.inf],
    "texts in it": ["a", "b", "c"],
    "400 digits in it": [0, 0, HUGE],
    "true in it": [True, True, True],
    "lists in it": [[0], [0], [1]],
}
NO_PLACE = {k: v for k, v in NO_VECTOR.items() if k != "zero"} | {
    "a wrong unit in it": ["1 kg", "0 mm", "0 mm"],
    "far away": [1e300, 0, 0],
}
NO_PART = NO_CHOICE | {
    "on nothing": {"on": "moon"},
    "an unknown key": {"on": "rim", "z": "<= 1"},
    "no bound": {"on": "rim", "x": "about 3"},
    "bound of a wrong unit": {"on": "rim", "x": "<= 3 kg"},
    "bound nan": {"on": "rim", "x": "<= nan"},
    "bound is a number": {"on": "rim", "x": 3},
    "nothing there": {"on": "rim", "x": ">= 3 km"},
    "bounds that exclude each other": {"on": "rim", "x": ["<= -1 mm", ">= 1 mm"]},
    "holes of a sheet without": "holes",
    "a point of three": {"point": [0, 0, 0]},
    "a point far away": {"point": [1.0, 1.0]},
    "a point nan": {"point": [math.nan, 0]},
    "a line of one point": {"line": [[0.0, 0.0]]},
    "a line of one place": {"line": [[0.0, 0.0], [0.0, 0.0]]},
    "a line that ends inside": {"line": [[0.0, 0.0], [0.0, 0.02]]},
    "a line outside": {"line": [[0.05, -0.02], [0.05, 0.02]]},
    "a line nan": {"line": [[0.0, math.nan], [0.0, 0.02]]},
    "two kinds of place": {"point": [0.0, 0.0], "line": ARM},
}
NO_AXES = NO_CHOICE | {"twice": "xx", "a fourth": "xw", "capital": "X", "blank": "x y"}
NO_DIRECTION = {k: v for k, v in NO_VECTOR.items() if k != "text"} | {
    "no axis": "w",
    "two axes": "xy",
    "plus plus": "++x",
}
NO_TIMES = NO_NUMBER | NO_LIST_OF_NUMBERS | {"falls": [1.0, 0.0], "minus": [-1.0, 1.0]}
NO_TIMES.pop("list")
NO_SERIES = NO_NUMBER | {
    "shares above 1": [[0.7, 1.0], [0.7, 2.0]],
    "a share below 0": [[-0.1, 1.0]],
    "a time of 0": [[0.1, 0.0]],
    "a time below 0": [[0.1, -1.0]],
    "a time of metres": [[0.1, "1 m"]],
    "one number": [[0.1]],
    "three": [[0.1, 1.0, 2.0]],
    "texts": [["a", "b"]],
    "nan": [[math.nan, 1.0]],
    "400 digits": [[0.1, HUGE]],
    "21 terms": [[0.01, 1.0 + k] for k in range(21)],
    "tables": [{"share": 0.1}],
}
NO_SERIES.pop("empty list")

FIELDS: dict[str, tuple[dict[str, Any], dict[Path_, dict[str, Any]]]] = {
    "held": (
        HELD,
        {
            ("supports", "left", "where"): NO_PART,
            ("supports", "left", "kind"): NO_CHOICE,
            ("supports", "right", "axes"): NO_AXES,
            ("loads", "push", "where"): NO_PART,
            ("loads", "push", "force"): NO_SIZE | NO_LIST_OF_NUMBERS | {"unit": "1 kg"},
            ("loads", "push", "direction"): NO_DIRECTION,
            ("loads", "poke", "where"): NO_PART,
            ("loads", "poke", "displacement"): NO_SIZE | NO_LIST_OF_NUMBERS | {"unit": "1 kg"},
            ("loads", "body", "body_force"): NO_SIZE | NO_LIST_OF_NUMBERS | {"unit": "1 kg"},
            ("loads", "body", "direction"): NO_DIRECTION,
            ("loads", "edge", "line_force"): NO_SIZE | NO_LIST_OF_NUMBERS | {"unit": "1 N"},
        },
    ),
    "blown": (
        BLOWN,
        {
            ("supports", "rim", "kind"): NO_CHOICE,
            ("loads", "blow", "pressure"): NO_SIZE | NO_LIST_OF_NUMBERS | {"unit": "1 N"},
        },
    ),
    "stopped": (
        STOPPED,
        {
            ("obstacles", "table", "shape"): NO_CHOICE,
            ("obstacles", "table", "point"): NO_PLACE,
            ("obstacles", "table", "normal"): NO_VECTOR,
            ("obstacles", "ball", "centre"): NO_PLACE,
            ("obstacles", "ball", "radius"): NO_LENGTH,
        },
    ),
    "aged": (
        AGED,
        {
            ("materials", "soft", "relaxation"): NO_SERIES,
            ("time", "hold"): NO_NUMBER | {"minus": -1.0, "unit": "1 m"},
            ("time", "milestones"): NO_TIMES,
        },
    ),
}
EXTREME_FIELDS: tuple[tuple[str, Path_], ...] = (
    ("held", ("loads", "push", "force")),
    ("held", ("loads", "poke", "displacement")),
    ("held", ("loads", "body", "body_force")),
    ("blown", ("loads", "blow", "pressure")),
    ("stopped", ("obstacles", "ball", "radius")),
    ("aged", ("time", "hold")),
)
TABLES = ("supports", "loads", "obstacles", "time")
CONTACT = ("--set", "solver.contact=barrier")


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    for base_name, (base, kinds) in FIELDS.items():
        yield accepted(f"{base_name}: as it is", base)
        for path, values in kinds.items():
            for label, value in values.items():
                name = f"{base_name}: {'.'.join(map(str, path))} {label}"
                yield refused(name, changed(base, path, value))
        yield from _keys_and_tables(base_name, base)
    for base_name, path in EXTREME_FIELDS:
        for label, value in EXTREME.items():
            tables = changed(FIELDS[base_name][0], path, value)
            yield _of(f"{base_name}: {path[-1]} = {label}", tables, Right.HANDLED, ("a.nc",))
    yield from _by_hand()


def refused(name: str, tables: dict[str, Any]) -> Attempt:
    return _of(name, tables, Right.REFUSED)


def accepted(name: str, tables: dict[str, Any]) -> Attempt:
    files = {"s.toml": document(tables), "study.toml": STUDY}
    return Attempt("surroundings", name, DRY, files, Right.ACCEPTED)


def _of(name: str, tables: dict[str, Any], right: Right, outputs: tuple[str, ...] = ()) -> Attempt:
    words = (*SOLVE, *CONTACT) if "obstacles" in tables else SOLVE
    return Attempt("surroundings", name, words, {"s.toml": document(tables)}, right, outputs)


def _keys_and_tables(base_name: str, base: dict[str, Any]) -> Iterator[Attempt]:
    for table in TABLES:
        if table not in base:
            continue
        for label, other in (("a number", 5), ("a text", "x"), ("a list", [1]), ("true", True)):
            yield refused(f"{base_name}: [{table}] is {label}", changed(base, (table,), other))
        odd = changed(base, (table, "odd"), 1)
        yield refused(f"{base_name}: a number in [{table}]", odd)
        for name, content in base[table].items():
            if not isinstance(content, dict):
                continue
            one = f"{base_name}: [{table}.{name}]"
            yield refused(f"{one} is empty", changed(base, (table, name), {}))
            yield refused(f"{one} has an unknown key", changed(base, (table, name, "odd"), 1))
            for new in ("", "a b", "1st", "\x1b[31m", "a.b", "a" * 10_000):
                renamed = copy.deepcopy(base)
                renamed[table][new] = renamed[table].pop(name)
                yield refused(f"{one} named {new[:9]!r}", renamed)


def _by_hand() -> Iterator[Attempt]:
    def of(name: str, base: dict[str, Any], *changes: tuple[Path_, Any]) -> Attempt:
        for path, value in changes:
            base = changed(base, path, value)
        return refused(f"by hand: {name}", base)

    push = HELD["loads"]["push"]
    yield of("a load of two kinds", HELD, (("loads", "push"), push | {"pressure": 1.0}))
    yield of("a load of no kind", HELD, (("loads", "push"), {"direction": "x"}))
    yield of("a pressure with a direction", BLOWN, (("loads", "blow", "direction"), "x"))
    yield of("a pressure on an edge", BLOWN, (("loads", "blow", "where"), "rim"))
    yield of("a line force on the whole sheet", HELD, (("loads", "edge", "where"), "sheet"))
    yield of("a pressure that nothing holds", {**BLOWN, "supports": {}})
    yield of(
        "values of two and of three milestones",
        HELD,
        (("prestretch", "milestones"), [1.001, 1.002]),
        (("loads", "push", "force"), [1e-5, 2e-5, 3e-5]),
    )
    yield of("30 thousand values", HELD, (("loads", "push", "force"), [1e-5] * 30_000))
    yield of("a hundred thousand supports", {**SHEET, "supports": _many({"kind": "clamped"})})
    yield of("a hundred thousand obstacles", {**SHEET, "obstacles": _many({"shape": "plane"})})
    yield of(
        "a sphere around the sheet",
        STOPPED,
        (("obstacles", "ball", "centre"), [0.0, 0.0, 0.0]),
        (("obstacles", "ball", "radius"), 0.1),
    )
    yield of("a plane through the sheet", STOPPED, (("obstacles", "table", "normal"), [1, 0, 0]))
    hole = {"shape": "polygon", "points": [[-0.03, -0.02], [0.03, -0.02], [0.0, 0.03]]}
    yield of(
        "a line through a hole",
        HELD,
        (("specimen", "outline"), {**hole, "holes": [SMALL]}),
    )
    for model in ("paper", "hinge"):
        for name, base in (("loads", BLOWN), ("obstacles", STOPPED), ("time", AGED)):
            attempt = refused(f"by hand: {name} in {model}", base)
            yield Attempt(
                attempt.kind,
                attempt.name,
                (*attempt.words, "--model", model),
                attempt.files,
                Right.EITHER,
                ("a.nc",),
            )


def _many(table: dict[str, Any]) -> dict[str, Any]:
    return {f"n{k}": table for k in range(100_000)}
