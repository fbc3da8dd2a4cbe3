"""Drawings and images named in a specimen file, replaced by the contours that they hold.

So a specimen carries its shapes with it: results and studies of it need no other file.
"""

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import shapely

from bilayer.drawings.contours import even_odd
from bilayer.drawings.image import SHADES, ImageSource
from bilayer.drawings.lines import Points
from bilayer.drawings.source import ORIGINS, DrawingSource
from bilayer.errors import InputError, fields_of
from bilayer.runtime.input_file import unreadable
from bilayer.runtime.terminal import Notice, keep_quiet
from bilayer.runtime.untrusted_file import read_in_child
from bilayer.specimen.outline import rings_of
from bilayer.specimen.pattern import KEPT_OR_CUT
from bilayer.specimen.tables import Tables, check_keys, required
from bilayer.specimen.units import in_si
from bilayer.validation import fraction, listed, not_negative, one_of, positive, text

Drawn = tuple[shapely.Geometry, str, int]
"""What contours bound, m; whether that is kept or cut; how many parts of an image were dropped."""
Found = TypeVar("Found")

SHORTEST_TIME, BYTES_PER_SECOND = 15.0, 1e5
"""Seconds that a drawing may take to be read: so many, and longer the larger it is."""
SHARPEST = 20.0
"""Corners are kept sharp by an offset up to this length over its width."""
DRAWING = tuple(field.name for field in fields(DrawingSource) if field.name != "path")
IMAGE = tuple(field.name for field in fields(ImageSource) if field.name != "path")
PATTERN_KEYS = {
    "drawing": ("drawing", *DRAWING, "dpi", "what", "kerf"),
    "image": ("image", *IMAGE, "what"),
}
OUTLINE_KEYS = {"drawing": ("drawing", *DRAWING, "dpi", "kerf"), "image": ("image", *IMAGE)}
LENGTHS = dict.fromkeys(
    ("unit", "tolerance", "joint", "slit", "origin", "kerf", "width", "smoothing"), "m"
) | {"least_area": "m^2"}


def with_drawings(
    tables: Tables, folder: Path | None, notice: Notice = keep_quiet
) -> dict[str, Any]:
    """Return the tables of a specimen file without drawings and images.

    Parameters
    ----------
    tables : mapping
        Of the long form; those of the short form are returned as they are.
    folder : Path or None
        Where the files lie that are named by a relative path; None: none may be named.
    notice : callable
        Takes a line for the user: how many parts of an image were left out.

    Raises
    ------
    InputError
        A file cannot be read, or a value is not as expected.
    ComputationError
        A package that reads drawings is not there.
    """
    whole = dict(tables)
    sheet = whole.get("specimen")
    if isinstance(sheet, Mapping) and _is_drawn(sheet.get("outline")):
        outline = _outline_table("specimen.outline", sheet["outline"], folder, notice)
        whole["specimen"] = {**sheet, "outline": outline}
    if isinstance(whole.get("patterns"), Mapping):
        whole["patterns"] = {
            name: _undrawn(f"patterns.{name}", table, folder, notice)
            for name, table in whole["patterns"].items()
        }
    if isinstance(whole.get("layers"), list):
        whole["layers"] = [
            {**layer, "pattern": _undrawn(f"layers[{k}].pattern", layer["pattern"], folder, notice)}
            if isinstance(layer, Mapping) and "pattern" in layer
            else layer
            for k, layer in enumerate(whole["layers"])
        ]
    return whole


def _is_drawn(table: Any) -> bool:
    return isinstance(table, Mapping) and ("drawing" in table or "image" in table)


def _undrawn(where: str, table: Any, folder: Path | None, notice: Notice) -> Any:
    """Return the table of a pattern, a drawn one by its contours."""
    if not _is_drawn(table):
        return table
    with fields_of(where):
        region, what, dropped = _region(table, folder, PATTERN_KEYS)
        _tell_dropped(where, dropped, table, notice)
        return {"kind": "contours", "contours": _plain(region), "what": what}


def _tell_dropped(where: str, count: int, table: Any, notice: Notice) -> None:
    if count:
        notice(f"{where}: {count} parts and holes below least_area = {table['least_area']} dropped")


def _outline_table(where: str, table: Any, folder: Path | None, notice: Notice) -> dict[str, Any]:
    with fields_of(where):
        region, _, dropped = _region({**table, "what": "kept"}, folder, OUTLINE_KEYS)
        _tell_dropped(where, dropped, table, notice)
        if not isinstance(region, shapely.Polygon):
            kind = "drawing" if "drawing" in table else "image"
            raise InputError(
                f"{kind} = {table[kind]!r}: has {len(region.geoms)} pieces, expected one"
            )
        points, *holes = _plain(region)
        return {"shape": "polygon", "points": points, **({"holes": holes} if holes else {})}


def _region(
    table: Mapping[str, Any], folder: Path | None, known: Mapping[str, tuple[str, ...]]
) -> Drawn:
    """Return what is drawn."""
    kind = "drawing" if "drawing" in table else "image"
    given = {key: value for key, value in table.items() if key in known[kind] or key != "what"}
    check_keys(kind, given, known[kind])
    read = _drawn if kind == "drawing" else _pictured
    return read(_path(kind, table[kind], folder), table)


def _path(kind: str, given: Any, folder: Path | None) -> Path:
    if folder is None:
        raise InputError(f"{kind} = {given!r}: expected in a specimen file alone")
    return folder / text(kind, given)


def _drawn(path: Path, table: Mapping[str, Any]) -> Drawn:
    chosen: dict[str, Any] = {k: text(k, table[k]) for k in ("layer", "colour") if k in table}
    lengths = in_si(
        "drawing", {k: v for k, v in table.items() if k in ("tolerance", "joint", "slit")}, LENGTHS
    )
    lengths = {key: positive(key, value, "m") for key, value in lengths.items()}
    source = DrawingSource(path, **chosen, **lengths, unit=_unit(table), origin=_origin(table))
    what = one_of("what", table.get("what", "cut"), KEPT_OR_CUT)
    width = in_si("drawing", {"kerf": table.get("kerf", 0.0)}, LENGTHS)
    kerf = not_negative("kerf", width["kerf"], "m")
    half = kerf / 2 if what == "cut" else -kerf / 2
    region = even_odd(_contours(source, _modified(path)))
    return (offset(region, half) if half else region), what, 0


@lru_cache(maxsize=16)
def _contours(source: DrawingSource, modified: float) -> list[Points]:
    """Return the contours of a drawing; the cases of a study read it once."""
    return _read_apart("drawing =", source.path, source.contours)


def _read_apart(what: str, path: Path, read: Callable[[], Found]) -> Found:
    """Return what is read from a drawing or an image, in a child process.

    A small file may stand for lines without an end, by blocks in blocks.
    """
    try:
        return read_in_child(path, what, read, SHORTEST_TIME, BYTES_PER_SECOND)
    except (MemoryError, RecursionError) as error:
        raise unreadable(path, what, f"reading it ends in {type(error).__name__}") from error


def _modified(path: Path) -> float:
    """Return the time of a file's last change, s; 0 if there is none."""
    return path.stat().st_mtime if path.is_file() else 0.0


def _pictured(path: Path, table: Mapping[str, Any]) -> Drawn:
    lengths = in_si("image", {key: table[key] for key in LENGTHS if key in table}, LENGTHS)
    source = ImageSource(
        path,
        positive("width", required("image", lengths, "width"), "m"),
        one_of("shade", table.get("shade", "dark"), SHADES),
        fraction("threshold", table.get("threshold", 0.5)),
        not_negative("smoothing", lengths.get("smoothing", 0.0)),
        not_negative("least_area", lengths.get("least_area", 0.0)),
    )
    contours, dropped = _read_apart("image =", path, source.contours)
    return even_odd(contours), one_of("what", table.get("what", "kept"), KEPT_OR_CUT), dropped


def offset(region: shapely.Geometry, distance: float) -> shapely.Geometry:
    """Return a region grown by a distance (shrunk by a negative one), corners sharp, m."""
    return region.buffer(distance, join_style="mitre", mitre_limit=SHARPEST)


def _unit(table: Mapping[str, Any]) -> float | None:
    """Return one unit of the drawing, m; None where the specimen does not say it."""
    if "unit" in table and "dpi" in table:
        raise InputError("dpi: not together with unit")
    if "dpi" in table:
        return 0.0254 / positive("dpi", table["dpi"])
    if "unit" not in table:
        return None
    name = table["unit"]
    given = f"1 {name}" if isinstance(name, str) and name[:1].isalpha() else name
    return positive("unit", in_si("drawing", {"unit": given}, LENGTHS)["unit"], "m")


def _origin(table: Mapping[str, Any]) -> str | tuple[float, float]:
    given = table.get("origin", "drawing")
    if isinstance(given, str):
        return one_of("origin", given, ORIGINS)
    pair = listed(
        "origin", in_si("drawing", {"origin": list(listed("origin", given))}, LENGTHS)["origin"]
    )
    if len(pair) != 2:
        raise InputError(f"origin = {given!r}: expected a pair [x, y], 'drawing' or 'centre'")
    return pair[0], pair[1]


def _plain(region: shapely.Geometry) -> list[list[list[float]]]:
    """Return the rings of a region as lists, to a tenth of a nanometre."""
    return [[[round(x, 10), round(y, 10)] for x, y in ring] for ring in rings_of(region)]
