"""Values that no field of their kind takes, and other ways to write those that it takes."""

from __future__ import annotations

import datetime
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from attack.toml_text import Raw

HUGE = 10**400
DEEP = Raw("[" * 60 + "]" * 60)

NO_NUMBER: dict[str, Any] = {
    "true": True,
    "empty text": "",
    "text": "x",
    "text nan": "nan",
    "decimal comma": "1,06",
    "NUL": "\0",
    "newline": "1\n2",
    "escape": "\x1b[31m1",
    "list": [0.04],
    "empty list": [],
    "list in list": [[]],
    "deep": DEEP,
    "table": {"value": 1},
    "empty table": {},
    "nan": math.nan,
    "inf": math.inf,
    "-inf": -math.inf,
    "overflow": Raw("1e400"),
    "400 digits": HUGE,
    "-400 digits": -HUGE,
    "5000 digits": Raw("9" * 5000),
    "date": datetime.date(1979, 5, 27),
    "time": datetime.time(7, 32),
    "moment": datetime.datetime(1979, 5, 27, 7, 32, tzinfo=datetime.UTC),
}
NO_TEXT: dict[str, Any] = {
    "number": 5,
    "true": True,
    "list": ["x"],
    "empty list": [],
    "table": {"value": 1},
    "nan": math.nan,
    "400 digits": HUGE,
    "date": datetime.date(1979, 5, 27),
}
NO_CHOICE = NO_TEXT | {
    "empty text": "",
    "unknown": "nonsense",
    "blank behind": "natural ",
    "NUL": "\0",
    "long": "n" * 100_000,
    "escape": "\x1b[2J",
    "newline": "a\nb",
    "surrogate-like": "\uffff",
}


def _quantities(good: str, wrong: tuple[str, ...]) -> dict[str, Any]:
    units = {f"unit {text}": text for text in wrong}
    return {
        **units,
        "no unit": "40",
        "no number": good,
        "two": f"1 {good} 2 {good}",
        "comma": f"4,5 {good}",
        "nan with unit": f"nan {good}",
        "inf with unit": f"inf {good}",
        "1e999 with unit": f"1e999 {good}",
        "hex": f"0x10 {good}",
        "power tower": f"1 {good}**{'9' * 30}",
        "code": "1 __import__('os').system('x')",
        "NUL in unit": f"1 {good}\0",
    }


NOT_POSITIVE: dict[str, Any] = {"zero": 0, "-0.0": -0.0, "minus": -0.001}
NO_LENGTH = (
    NO_NUMBER
    | NOT_POSITIVE
    | _quantities("mm", ("4 kg", "4 deg", "4 mmm", "4 Pa", "-4 mm", "0 mm"))
)
NO_LENGTH_OR_ZERO = {k: v for k, v in NO_LENGTH.items() if k not in ("zero", "-0.0", "unit 0 mm")}
NO_STRESS = NO_NUMBER | NOT_POSITIVE | _quantities("kPa", ("4 kg", "4 mm", "4 N", "-4 kPa"))
NO_CONSTANT = {k: v for k, v in NO_STRESS.items() if k not in (*NOT_POSITIVE, "unit -4 kPa")}
"""Of a law: it may be negative as long as the law's small-strain modulus is not."""
NO_ANGLE = NO_NUMBER | NOT_POSITIVE | _quantities("deg", ("4 kg", "4 mm", "4 %", "-4 deg"))
NO_TURN = NO_NUMBER | _quantities("deg", ("4 kg", "4 mm", "4 %"))
NO_DENSITY = NO_NUMBER | NOT_POSITIVE | _quantities("kg/m^3", ("4 kg", "4 mm"))
NO_ACCELERATION = NO_NUMBER | {"minus": -1.0} | _quantities("m/s^2", ("4 kg", "4 m/s"))
NO_COUNT = (
    NO_NUMBER
    | NOT_POSITIVE
    | {"half": 2.5, "text 5": "5", "with a unit": "5 mm", "1e300": 1e300, "30 digits": 10**30}
)
NO_RATIO = NO_NUMBER | {"minus": -1.0, "one": 1.0, "text": "0.49"}
NO_NAME_OF_TABLE = NO_CHOICE
NO_LAYER_NAME = {k: v for k, v in NO_CHOICE.items() if k != "unknown"}
NO_STRETCHES: dict[str, Any] = {
    name: value for name, value in NO_NUMBER.items() if name not in ("list",)
} | {
    "one number": 1.03,
    "zero": [0],
    "minus": [-1.03],
    "in per cent": [3],
    "too large": [1e300],
    "too small": [1e-300],
    "texts": ["1.03"],
    "true in it": [True],
    "nan in it": [1.03, math.nan],
    "400 digits in it": [HUGE],
    "date in it": [datetime.date(1979, 5, 27)],
    "single in pair": [[1.03]],
    "three": [[1.03, 1.03, 1.03]],
    "pair with text": [[1.03, "x"]],
    "pair in pair": [[[1.03, 1.0], 1.0]],
    "tables": [{"x": 1.03}],
}
del NO_STRETCHES["in per cent"]  # 3 is a stretch of 3, as good as any
NO_RING: dict[str, Any] = {
    **{name: value for name, value in NO_NUMBER.items() if name not in ("list",)},
    "numbers": [1, 2, 3],
    "one corner": [[0.0, 0.0]],
    "two corners": [[0.0, 0.0], [0.02, 0.0]],
    "on a line": [[0.0, 0.0], [0.01, 0.0], [0.02, 0.0]],
    "one point": [[0.01, 0.01]] * 4,
    "bow tie": [[0.0, 0.0], [0.02, 0.02], [0.02, 0.0], [0.0, 0.02]],
    "wound twice": [[0.0, 0.0], [0.02, 0.0], [0.02, 0.02], [0.0, 0.02]] * 2,
    "touches itself": [
        [-0.02, -0.02],
        [0.02, -0.02],
        [0.0, 0.0],
        [0.02, 0.02],
        [-0.02, 0.02],
        [0.0, 0.0],
    ],
    "spike": [[0.0, 0.0], [0.02, 0.0], [0.04, 0.0], [0.02, 0.0], [0.0, 0.02]],
    "three numbers": [[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.02, 0.0]],
    "nan in it": [[0.0, 0.0], [math.nan, 0.0], [0.0, 0.02]],
    "inf in it": [[0.0, 0.0], [math.inf, 0.0], [0.0, 0.02]],
    "400 digits in it": [[0, 0], [HUGE, 0], [0, 1]],
    "text in it": [[0.0, 0.0], ["x", 0.0], [0.0, 0.02]],
    "wrong unit in it": [[0.0, 0.0], ["20 kg", 0.0], [0.0, 0.02]],
    "true in it": [[0.0, 0.0], [True, 0.0], [0.0, 0.02]],
    "date in it": [[0.0, 0.0], [datetime.date(1979, 5, 27), 0.0], [0.0, 0.02]],
    "tables": [{"x": 0.0, "y": 0.0}] * 3,
}
NO_RINGS: dict[str, Any] = {name: value for name, value in NO_NUMBER.items() if name != "list"} | {
    f"ring {name}": [value] for name, value in NO_RING.items()
}

BAD: dict[str, dict[str, Any]] = {
    "length": NO_LENGTH,
    "length or 0": NO_LENGTH_OR_ZERO,
    "stress": NO_STRESS,
    "constant": NO_CONSTANT,
    "angle": NO_ANGLE,
    "turn": NO_TURN,
    "density": NO_DENSITY,
    "acceleration": NO_ACCELERATION,
    "count": NO_COUNT,
    "ratio": NO_RATIO,
    "choice": NO_CHOICE,
    "name": NO_TEXT,
    "layer name": NO_LAYER_NAME,
    "reference": NO_NAME_OF_TABLE,
    "stretches": NO_STRETCHES,
    "ring": NO_RING,
    "rings": NO_RINGS,
}
"""By kind of field."""

EXTREME: dict[str, Any] = {
    "1e300": 1e300,
    "-1e300": -1e300,
    "1e-300": 1e-300,
    "denormal": 5e-324,
    "1e30": 1e30,
    "1e-30": 1e-30,
    "1e9": 1e9,
    "30 digits": 10**30,
    "3 (of metres?)": 3,
}
"""Numbers that may be in range, and that nobody expects."""

SAME: dict[str, Any] = {
    "length": lambda v: (f"{1e3 * v!r} mm", f"{1e2 * v!r} cm", f" {v!r}  m ", f"{v:e} m"),
    "stress": lambda v: (f"{1e-3 * v!r} kPa", f"{v!r} Pa", f"{1e-6 * v!r} MPa", f"{v!r} N/m^2"),
    "angle": lambda v: (f"{math.degrees(v)!r} deg", f"{v!r} rad", f"{1e3 * v!r} mrad"),
    "density": lambda v: (f"{1e-3 * v!r} g/cm^3", f"{v!r} kg/m3"),
    "count": lambda v: (float(v),),
    "stretches": lambda v: ([[x, x] for x in v], [*v, *v]),
}
"""By kind: other ways to write the same."""
NO_FILES: dict[str, Callable[[Path], object]] = {
    "a folder": Path.mkdir,
    "a pipe": os.mkfifo,
    "zeros without end": lambda path: path.symlink_to("/dev/zero"),
    "a link to nothing": lambda path: path.symlink_to("none"),
    "a link to itself": lambda path: path.symlink_to(path.name),
}
"""What makes something else where a file is expected."""
