"""Specimen files: each field of each form with what it does not take, and whole files."""

from __future__ import annotations

import copy
import random
import re
from collections.abc import Iterator, Mapping
from typing import Any

from attack.attempt import Attempt, Right
from attack.toml_text import Raw, document
from attack.values import BAD, EXTREME, SAME

Path_ = tuple[Any, ...]

SHORT: dict[str, Any] = {
    "specimen": {"name": "odd", "outer_radius": 0.04},
    "cut": {"strips": 5, "inner_radius": 0.008, "cutout_angle": 0.3},
    "substrate": {
        "thickness": 0.001,
        "law": "mooney-rivlin",
        "young_modulus": 116250.0,
        "c01_over_c10": 3.004,
        "poisson_ratio": 0.49,
        "density": 960.0,
    },
    "kirigami": {
        "side": "above",
        "thickness": 0.001,
        "young_modulus": 368988.0,
        "poisson_ratio": 0.49,
        "density": 960.0,
    },
    "prestretch": {"milestones": [1.001], "layers": ["substrate"], "thickness": "natural"},
    "gravity": {"acceleration": 0.0},
    "mesh": {"size": 0.02},
}
SHORT_KINDS: dict[Path_, str] = {
    ("specimen", "name"): "name",
    ("specimen", "outer_radius"): "length",
    ("cut", "strips"): "count",
    ("cut", "inner_radius"): "length",
    ("cut", "cutout_angle"): "angle",
    ("substrate", "thickness"): "length",
    ("substrate", "law"): "choice",
    ("substrate", "young_modulus"): "stress",
    ("substrate", "poisson_ratio"): "ratio",
    ("substrate", "density"): "density",
    ("kirigami", "side"): "choice",
    ("kirigami", "thickness"): "length",
    ("kirigami", "young_modulus"): "stress",
    ("kirigami", "density"): "density",
    ("prestretch", "milestones"): "stretches",
    ("prestretch", "thickness"): "choice",
    ("gravity", "acceleration"): "acceleration",
    ("mesh", "size"): "length",
}
NEEDED = {
    ("specimen", "outer_radius"),
    ("cut", "strips"),
    ("cut", "inner_radius"),
    ("cut", "cutout_angle"),
    ("substrate", "thickness"),
    ("substrate", "young_modulus"),
    ("kirigami", "thickness"),
    ("kirigami", "young_modulus"),
    ("prestretch", "milestones"),
}

SQUARE = [[-0.03, -0.02], [0.03, -0.02], [0.03, 0.02], [-0.03, 0.02]]
SMALL = [[-0.01, -0.01], [0.01, -0.01], [0.01, 0.01], [-0.01, 0.01]]
LONG: dict[str, Any] = {
    "specimen": {
        "name": "odd",
        "outline": {"shape": "rectangle", "width": 0.06, "height": 0.04, "corner_radius": 0.002},
    },
    "layers": [
        {"name": "lower", "thickness": 0.001, "material": "stiff", "pattern": "cutouts"},
        {
            "name": "substrate",
            "thickness": 0.001,
            "material": "soft",
            "response": {"kind": "path", "factor": 1.0, "angle": 0.0},
        },
        {"name": "upper", "thickness": 0.0005, "material": "stiff", "pattern": "profile"},
    ],
    "patterns": {
        "cutouts": {"kind": "sectors", "strips": 4, "inner_radius": 0.008, "cutout_angle": 0.3},
        "profile": {
            "kind": "sector-profile",
            "strips": 4,
            "radii": [0.01, 0.015, 0.02],
            "half_angles": [0.3, 0.35, 0.4],
        },
    },
    "materials": {
        "soft": {"law": "neo-hookean", "young_modulus": 1e5, "poisson_ratio": 0.49},
        "stiff": {
            "law": "mooney-rivlin",
            "c10": 17880.0,
            "c01": 84450.0,
            "d1": 1e-5,
            "density": 960.0,
        },
    },
    "prestretch": {"milestones": [1.001]},
    "mesh": {"size": 0.012},
}
LONG_KINDS: dict[Path_, str] = {
    ("specimen", "outline", "shape"): "choice",
    ("specimen", "outline", "width"): "length",
    ("specimen", "outline", "corner_radius"): "length or 0",
    ("layers", 0, "name"): "layer name",
    ("layers", 0, "thickness"): "length",
    ("layers", 0, "material"): "reference",
    ("layers", 0, "pattern"): "reference",
    ("layers", 1, "response", "kind"): "choice",
    ("layers", 1, "response", "factor"): "turn",
    ("layers", 1, "response", "angle"): "turn",
    ("patterns", "cutouts", "kind"): "choice",
    ("patterns", "cutouts", "strips"): "count",
    ("patterns", "cutouts", "inner_radius"): "length",
    ("patterns", "cutouts", "cutout_angle"): "angle",
    ("patterns", "profile", "strips"): "count",
    ("materials", "soft", "law"): "choice",
    ("materials", "soft", "young_modulus"): "stress",
    ("materials", "stiff", "c10"): "constant",
    ("materials", "stiff", "density"): "density",
}
OUTLINES: dict[str, tuple[dict[str, Any], dict[str, str]]] = {
    "ellipse": ({"width": 0.06, "height": 0.04}, {"width": "length", "height": "length"}),
    "regular-polygon": (
        {"sides": 6, "outer_radius": 0.03, "angle": 0.0},
        {"sides": "count", "outer_radius": "length", "angle": "turn"},
    ),
    "polygon": ({"points": SQUARE, "holes": [SMALL]}, {"points": "ring", "holes": "rings"}),
}
PATTERNS: dict[str, tuple[dict[str, Any], dict[str, str]]] = {
    "polygons": (
        {"polygons": [SMALL], "what": "cut"},
        {"polygons": "rings", "what": "choice"},
    ),
    "cross": (
        {"arm_width": 0.008, "arm_length": 0.03, "angle": 0.0},
        {"arm_width": "length", "arm_length": "length", "angle": "turn"},
    ),
}
FITS: dict[str, Any] = {"sides": 6}

HARMLESS = (("name", "empty text"), ("holes", "empty list"))
"""Values that these fields take, or that other attempts go through."""
MESH = ("mesh", "s.toml", "-o", "m.vtu", "--quiet")
SOLVE = ("solve", "s.toml", "--solver", "dshell", "-o", "a.nc", "--quiet")
DRY = ("study", "study.toml", "-o", "st", "--dry-run", "--quiet")
STUDY = 'specimen = "s.toml"\nsolver = "dshell"\n'


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    for base_name, base, kinds in _bases():
        for path, kind in kinds.items():
            yield from _bad_values(base_name, base, path, kind)
            yield from _extreme_values(base_name, base, path, kind)
            yield from _same_values(base_name, base, path, kind)
        yield from _keys_and_tables(base_name, base)
    for path in sorted(NEEDED):
        yield refused(f"short: {'.'.join(path)} missing", _without(SHORT, path), path[-1])
    yield from _by_hand()
    yield from _texts(chance)


def refused(name: str, tables: Mapping[str, Any], says: str = "") -> Attempt:
    return Attempt("specimen file", name, SOLVE, {"s.toml": document(tables)}, says=says)


def accepted(name: str, tables: Mapping[str, Any]) -> Attempt:
    files = {"s.toml": document(tables), "study.toml": STUDY}
    return Attempt("specimen file", name, DRY, files, Right.ACCEPTED)


def _bases() -> Iterator[tuple[str, dict[str, Any], dict[Path_, str]]]:
    yield "short", SHORT, SHORT_KINDS
    yield "long", LONG, LONG_KINDS
    for shape, (keys, kinds) in OUTLINES.items():
        tables = copy.deepcopy(LONG)
        tables["specimen"]["outline"] = {"shape": shape, **keys}
        yield shape, tables, {("specimen", "outline", key): kind for key, kind in kinds.items()}
    for pattern, (keys, kinds) in PATTERNS.items():
        tables = copy.deepcopy(LONG)
        tables["patterns"]["cutouts"] = {"kind": pattern, **keys}
        yield pattern, tables, {("patterns", "cutouts", key): kind for key, kind in kinds.items()}


def changed(tables: Mapping[str, Any], path: Path_, value: Any) -> dict[str, Any]:
    """Return the tables with one value changed."""
    copied = copy.deepcopy(dict(tables))
    place: Any = copied
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    return copied


def _without(tables: Mapping[str, Any], path: Path_) -> dict[str, Any]:
    copied = copy.deepcopy(dict(tables))
    place: Any = copied
    for step in path[:-1]:
        place = place[step]
    del place[path[-1]]
    return copied


def _named(path: Path_) -> str:
    return ".".join(map(str, path))


def _bad_values(
    base_name: str, base: Mapping[str, Any], path: Path_, kind: str
) -> Iterator[Attempt]:
    for label, value in BAD[kind].items():
        if (path[-1], label) in HARMLESS:
            continue
        says = re.escape(str(path[-1]))
        if label.endswith(("5000 digits", "deep")):  # of the file as a whole
            says += r"|TOML|s\.toml"
        if path[-1] in ("kind", "pattern") or path == ("layers", 0, "name"):
            says = ""
        yield refused(f"{base_name}: {_named(path)} {label}", changed(base, path, value), says)


def _extreme_values(
    base_name: str, base: Mapping[str, Any], path: Path_, kind: str
) -> Iterator[Attempt]:
    if kind in ("length", "stress", "angle", "density", "acceleration", "count", "turn", "ratio"):
        for label, value in EXTREME.items():
            if kind == "count" and label == "3 (of metres?)":
                continue
            text = document(changed(base, path, value))
            yield Attempt(
                "specimen file",
                f"{base_name}: {_named(path)} = {label}",
                SOLVE,
                {"s.toml": text},
                Right.HANDLED,
                outputs=("a.nc",),
            )


def _same_values(
    base_name: str, base: Mapping[str, Any], path: Path_, kind: str
) -> Iterator[Attempt]:
    if kind not in SAME:
        return
    value: Any = base
    for step in path:
        value = value[step]
    for other in SAME[kind](value):
        yield accepted(f"{base_name}: {_named(path)} as {other}", changed(base, path, other))


def _keys_and_tables(base_name: str, base: Mapping[str, Any]) -> Iterator[Attempt]:
    yield accepted(f"{base_name}: as it is", base)
    for table, content in base.items():
        for label, other in (
            ("a number", 5),
            ("a text", "x"),
            ("a list", [1]),
            ("true", True),
            ("a list of lists", [[]]),
            ("a date", Raw("1979-05-27")),
        ):
            yield refused(f"{base_name}: [{table}] is {label}", changed(base, (table,), other))
        if isinstance(content, dict) and table not in ("patterns", "materials"):
            odd = changed(base, (table, "unknown_key"), 1)
            yield refused(f"{base_name}: unknown key in [{table}]", odd, "unknown_key")
            empty = changed(base, (table, ""), 1)
            yield refused(f"{base_name}: empty key in [{table}]", empty)
    for name in ("unknown", "", "\x1b[31m", "layer", "a.b", "cut\n"):
        yield refused(f"{base_name}: table {name!r}", {**base, name: {"x": 1}})
    yield refused(
        f"{base_name}: the other form's table",
        {**base, "layers" if base_name == "short" else "cut": LONG["layers"]},
    )


def _by_hand() -> Iterator[Attempt]:
    long = copy.deepcopy(LONG)

    def of(name: str, *changes: tuple[Path_, Any], says: str = "") -> Attempt:
        tables: Any = long
        for path, value in changes:
            tables = changed(tables, path, value)
        return refused(f"by hand: {name}", tables, says)

    layer = long["layers"][0]
    yield of("no layers", (("layers",), []))
    yield of("a layer is a number", (("layers",), [5]))
    yield of("a layer is empty", (("layers",), [{}]))
    yield of("thirteen layers", (("layers",), [layer | {"name": f"l{k}"} for k in range(13)]))
    yield of("two layers of one name", (("layers",), [layer, layer]), says="lower")
    yield of("unknown material", (("layers", 0, "material"), "stif"), says="did you mean 'stiff'")
    yield of("unknown key of a layer", (("layers", 0, "thicknes"), 1), says="thickness")
    yield of("patterns is empty", (("patterns",), {}), says="pattern")
    yield of("a material is a number", (("materials", "stiff"), 5), says="stiff")
    yield of(
        "all is cut away",
        (("patterns", "cutouts"), {"kind": "polygons", "what": "cut", "polygons": [SQUARE]}),
    )
    beyond = [[1.0, 1.0], [1.1, 1.0], [1.0, 1.1]]
    yield of(
        "the pattern lies beyond the sheet",
        (("patterns", "cutouts"), {"kind": "polygons", "what": "kept", "polygons": [beyond]}),
    )
    yield of(
        "the hole lies beyond the sheet",
        (("specimen", "outline"), {"shape": "polygon", "points": SQUARE, "holes": [beyond]}),
    )
    yield of(
        "the hole is the sheet",
        (("specimen", "outline"), {"shape": "polygon", "points": SQUARE, "holes": [SQUARE]}),
    )
    yield of(
        "two holes overlap",
        (("specimen", "outline"), {"shape": "polygon", "points": SQUARE, "holes": [SMALL, SMALL]}),
    )
    yield of("cutouts overlap", (("patterns", "cutouts", "cutout_angle"), 1.6), says="overlap")
    yield of("radii fall", (("patterns", "profile", "radii"), [0.02, 0.015, 0.008]), says="radii")
    yield of("too few half angles", (("patterns", "profile", "half_angles"), [0.1]))
    yield of("half angles of 0", (("patterns", "profile", "half_angles"), [0, 0, 0]))
    yield of(
        "sides without end",
        (
            ("specimen", "outline"),
            {"shape": "regular-polygon", "sides": 10**9, "outer_radius": 0.03},
        ),
    )
    yield of("moduli and constants", (("materials", "stiff", "young_modulus"), 1e5))
    yield of("a constant of another law", (("materials", "soft", "c01"), 1e5))
    yield of("mesh coarser than the sheet", (("mesh", "size"), 1.0), says="mesh.size")
    yield of("corner size above the size", (("mesh", "corner_size"), 0.05), says="corner_size")
    yield of("a mesh of 1e12 triangles", (("mesh", "size"), 1e-8), says="mesh.size")
    yield of(
        "metres for millimetres",
        (("specimen", "outline"), {"shape": "rectangle", "width": 60, "height": 40}),
        says="metres",
    )
    yield of(
        "fixed stretch of a path",
        (("layers", 1, "response"), {"kind": "path", "stretch": [1.1, 1.0]}),
        says="stretch",
    )
    yield of("factor of nothing", (("layers", 1, "response"), {"kind": "none", "factor": 2.0}))
    yield of("a factor that turns it inside out", (("layers", 1, "response", "factor"), -2000.0))
    yield of("width and outer_radius", (("specimen", "outer_radius"), 0.03), says="outer_radius")
    yield of("no outline at all", (("specimen",), {"name": "odd"}), says="outer_radius")
    for name in ("", "1st", "a b", "a/b", "../x", "a\nb", "a.b", "\x1b[31m", "a" * 10_000, "ü"):
        one = [layer | {"name": name}, *long["layers"][1:]]
        yield of(f"a layer named {name[:12]!r}", (("layers",), one))
    cut = SHORT["cut"]
    for name, other in (
        ("inner radius beyond the disc", cut | {"inner_radius": 0.05}),
        ("cutouts overlap", cut | {"strips": 30}),
        ("no strips", cut | {"strips": 0}),
        ("a million strips", cut | {"strips": 10**6, "cutout_angle": 1e-7}),
    ):
        yield refused(f"by hand: {name}", {**SHORT, "cut": other}, "cut")
    for layers in (
        [],
        ["x"],
        "substrate",
        ["substrate", "substrate"],
        [5],
        [["substrate"]],
        5,
        {},
        [""],
        None,
    ):
        if layers is None:
            continue
        tables = changed(SHORT, ("prestretch", "layers"), layers)
        right = Right.EITHER if layers == ["substrate", "substrate"] else Right.REFUSED
        yield Attempt(
            "specimen file",
            f"by hand: prestretch.layers = {layers}",
            SOLVE,
            {"s.toml": document(tables)},
            right,
            ("a.nc",),
            says="layers",
        )
    many = changed(SHORT, ("prestretch", "milestones"), [1.001] * 30_000)
    yield Attempt(
        "specimen file",
        "by hand: 30000 milestones",
        DRY,
        {"s.toml": document(many), "study.toml": STUDY},
        Right.HANDLED,
    )
    for name in ("a" * 10_000, "日本語", "$\\frac{", "a\nb", "\x1b[31m", "%s %d {0}", ""):
        named = changed(SHORT, ("specimen", "name"), name)
        yield Attempt(
            "specimen file",
            f"by hand: specimen.name = {name[:12]!r}",
            SOLVE,
            {"s.toml": document(named)},
            Right.EITHER,
            ("a.nc",),
        )
    corners = 20_000
    circle = Raw(
        "["
        + ", ".join(
            f"[{0.03 * _cos(k, corners)!r}, {0.03 * _sin(k, corners)!r}]" for k in range(corners)
        )
        + "]"
    )
    yield Attempt(
        "specimen file",
        "by hand: a polygon of 20000 corners",
        DRY,
        {
            "s.toml": document(
                changed(LONG, ("specimen", "outline"), {"shape": "polygon", "points": circle})
            ),
            "study.toml": STUDY,
        },
        Right.EITHER,
    )


def _cos(k: int, n: int) -> float:
    import math

    return math.cos(2 * math.pi * k / n)


def _sin(k: int, n: int) -> float:
    import math

    return math.sin(2 * math.pi * k / n)


def _texts(chance: random.Random) -> Iterator[Attempt]:
    """Yield whole files: encodings, cut off, changed at random."""
    good = document(SHORT)
    bad: dict[str, bytes] = {
        "empty": b"",
        "blank lines": b"\n\n\n",
        "binary": bytes(range(256)),
        "zeros": bytes(1000),
        "UTF-16": good.encode("utf-16"),
        "UTF-32": good.encode("utf-32"),
        "Latin-1": good.encode() + b"# \xe9\n",
        "a lone surrogate": good.encode() + b"# \xed\xa0\x80\n",
        "NUL in it": good.encode() + b"\0",
        "an escape in it": good.encode() + b"\x1b[31m\n",
        "JSON": b'{"specimen": {"outer_radius": 0.04}}',
        "YAML": b"specimen:\n  outer_radius: 0.04\n",
        "a table twice": (good + "[specimen]\n").encode(),
        "a key twice": b"[specimen]\nname = 1\nname = 2\n",
        "deep lists": b"[specimen]\nname = " + b"[" * 5000 + b"]" * 5000,
        "deep tables": b"[specimen]\nname = " + b"{a=" * 5000 + b"1" + b"}" * 5000,
        "dotted without end": b"[" + b".".join([b"a"] * 5000) + b"]\n",
        "a netCDF file": b"\x89HDF\r\n\x1a\n" + bytes(100),
        "open text": b'[specimen]\nname = "x\n',
        "open list": b"[prestretch]\nmilestones = [1.03,\n",
    }
    for name, content in bad.items():
        yield Attempt("specimen file", f"text: {name}", SOLVE, {"s.toml": content})
    for name, content in {
        "a byte order mark": good.encode("utf-8-sig"),
        "CRLF": good.replace("\n", "\r\n").encode(),
        "carriage returns alone": good.replace("\n", "\r").encode(),
        "comments": b"# \xc3\xa9\n" + good.encode() + b"\n\n# end",
        "a million blanks": good.encode() + b" " * 1_000_000,
        "no newline at the end": good.rstrip().encode(),
    }.items():
        yield Attempt(
            "specimen file",
            f"text: {name}",
            DRY,
            {"s.toml": content, "study.toml": STUDY},
            Right.ACCEPTED,
        )
    for number in range(40):
        end = chance.randrange(1, len(good) - 2)
        yield Attempt(
            "specimen file",
            f"text: cut off {number}",
            SOLVE,
            {"s.toml": good[:end]},
            Right.HANDLED,
            ("a.nc",),
        )
    for number in range(160):
        yield Attempt(
            "specimen file",
            f"text: changed at random {number}",
            SOLVE,
            {"s.toml": changed_text(good, chance)},
            Right.HANDLED,
            ("a.nc",),
        )


def changed_text(text: str, chance: random.Random) -> str:
    """Return a text with a few letters and words exchanged, doubled, or gone."""
    for _ in range(chance.randint(1, 3)):
        at = chance.randrange(len(text))
        until = min(len(text), at + chance.choice((1, 1, 1, 3, 12)))
        put = chance.choice(
            (
                "",
                text[at:until] * 2,
                chance.choice("[]{}=\".,#-+eE0123456789\n \t'\\_naif"),
                "-",
                "e9",
                "\0",
                "é",
                chance.choice(("true", "nan", '"', "[[", "]]", "= =", "1979-05-27")),
            )
        )
        text = text[:at] + put + text[until:]
    return text
