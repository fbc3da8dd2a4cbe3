"""Drawings and images as patterns: damaged, of no closed contours, without end, from elsewhere."""

from __future__ import annotations

import io
import os
import random
from collections.abc import Iterator
from typing import Any

from attack.attempt import Attempt, Right
from attack.specimen_files import LONG, STUDY, changed
from attack.toml_text import document
from attack.values import NO_CHOICE, NO_FILES, NO_LENGTH

DRY = ("study", "study.toml", "-o", "st", "--dry-run", "--quiet")
SVG = (
    "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' "
    "width='60mm' height='40mm' viewBox='0 0 60 40'>{}</svg>"
)
SQUARE = "<path d='M20 10 L40 10 L40 30 L20 30 Z' fill='none' stroke='red'/>"
DAMAGES = 40
PATHS = {
    "open": "M20 10 L40 10 L40 30",
    "a bow tie": "M20 10 L40 30 L40 10 L20 30 Z",
    "a point": "M20 10 Z",
    "a line": "M20 10 L40 10 Z",
    "nan": "M20 nan L40 10 L40 30 Z",
    "inf": "M20 1e999 L40 10 L40 30 Z",
    "huge": "M1e300 1e300 L40 10 L40 30 Z",
    "letters": "Mxx yy Q",
    "beyond the sheet": "M200 100 L400 100 L400 300 Z",
    "twice": "M20 10 L40 10 L40 30 L20 30 Z M20 10 L40 10 L40 30 L20 30 Z",
    "all of the sheet": "M-100 -100 L200 -100 L200 200 L-100 200 Z",
    "cut off": "M20 10 C40 10",
}


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    good = SVG.format(SQUARE)
    yield _of("good: svg", good, "d.svg", Right.ACCEPTED)
    yield _of("good: svg with CRLF", good.replace(">", ">\r\n"), "d.svg", Right.ACCEPTED)
    yield _of("good: dxf", _dxf(), "d.dxf", Right.ACCEPTED)
    yield _image("good: png", _png(), Right.ACCEPTED)
    for name, path in PATHS.items():
        yield _of(f"svg path: {name}", SVG.format(f"<path d='{path}'/>"), "d.svg")
    yield from _svg_by_hand()
    for ending, whole in (("svg", good.encode()), ("dxf", _dxf())):
        for number in range(DAMAGES):
            end = chance.randrange(len(whole) - 1)
            yield _of(f"{ending} cut off {number}", whole[:end], f"d.{ending}", Right.EITHER)
            damaged = _changed(whole, chance)
            yield _of(f"{ending} changed {number}", damaged, f"d.{ending}", Right.EITHER)
    for number in range(DAMAGES):
        yield _image(f"png cut off {number}", _png()[: chance.randrange(len(_png()) - 1)])
        yield _image(f"png changed {number}", _changed(_png(), chance))
    yield from _no_drawings()
    yield from _keys()


def _of(
    name: str,
    content: Any,
    file: str,
    right: Right = Right.REFUSED,
    **keys: Any,
) -> Attempt:
    table = {"drawing": file, "origin": "centre", **keys}
    tables = changed(LONG, ("layers", 0, "pattern"), table)
    return Attempt(
        "drawing file",
        name,
        DRY,
        {"s.toml": document(tables), "study.toml": STUDY, file: content},
        right,
        says="drawing|pattern|TOML|nested|digits" if right is Right.REFUSED else "",
    )


def _image(name: str, content: Any, right: Right = Right.EITHER, **keys: Any) -> Attempt:
    table = {"image": "i.png", "width": 0.04, **keys}
    tables = changed(LONG, ("layers", 0, "pattern"), table)
    files = {"s.toml": document(tables), "study.toml": STUDY, "i.png": content}
    return Attempt("drawing file", name, DRY, files, right)


def _png(width: int = 64, height: int = 48) -> bytes:
    """Return an image with a dark disc on white."""
    import numpy as np
    from PIL import Image

    y, x = np.mgrid[:height, :width]
    dark = (x - width / 2) ** 2 + (y - height / 2) ** 2 < (height / 4) ** 2
    held = io.BytesIO()
    Image.fromarray(np.where(dark, 0, 255).astype("u1")).save(held, "PNG")
    return held.getvalue()


def _dxf() -> bytes:
    """Return a drawing with a square in mm."""
    import ezdxf

    drawing = ezdxf.new(units=4)
    drawing.modelspace().add_lwpolyline([(20, 10), (40, 10), (40, 30), (20, 30)], close=True)
    held = io.StringIO()
    drawing.write(held)
    return held.getvalue().encode()


def _changed(content: bytes, chance: random.Random) -> bytes:
    damaged = bytearray(content)
    for _ in range(chance.choice((1, 2, 8))):
        damaged[chance.randrange(len(damaged))] = chance.randrange(256)
    return bytes(damaged)


def _svg_by_hand() -> Iterator[Attempt]:
    outside = "<path d='M20 10 L40 10 L40 30 L20 30 Z'/>"
    yield _of("svg without a unit", f"<svg viewBox='0 0 60 40'>{SQUARE}</svg>", "d.svg")
    yield _of("svg without a path", SVG.format(""), "d.svg")
    yield _of("svg of a text alone", SVG.format("<text>x</text>"), "d.svg")
    yield _of("svg: a group in groups", SVG.format("<g>" * 5000 + SQUARE + "</g>" * 5000), "d.svg",
              Right.EITHER)  # fmt: skip
    used = "<g id='a'><use xlink:href='#a'/></g>"
    yield _of("svg: a group that uses itself", SVG.format(used + SQUARE), "d.svg", Right.EITHER)
    many = "".join(
        f"<g id='g{k}'>" + f"<use xlink:href='#g{k + 1}'/>" * 10 + "</g>" for k in range(9)
    )
    yield _of("svg: 1e9 uses", SVG.format(many + f"<g id='g9'>{SQUARE}</g>"), "d.svg", Right.EITHER)
    bomb = "<!DOCTYPE svg [<!ENTITY a 'aaaaaaaaaa'>" + "".join(
        f"<!ENTITY {chr(98 + k)} '{f'&{chr(97 + k)};' * 10}'>" for k in range(10)
    )
    yield _of("svg: a bomb of entities", f"{bomb}]>" + SVG.format("<text>&k;</text>" + outside),
              "d.svg", Right.EITHER)  # fmt: skip
    stolen = "<!DOCTYPE svg [<!ENTITY a SYSTEM 'file:///etc/passwd'>]>"
    yield _of("svg: an entity of another file", stolen + SVG.format("<text>&a;</text>"), "d.svg")
    yield _of("svg: a scale of 0", SVG.format(f"<g transform='scale(0)'>{SQUARE}</g>"), "d.svg")
    yield _of("svg: a transform of letters", SVG.format(f"<g transform='rotat(x'>{SQUARE}</g>"),
              "d.svg", Right.EITHER)  # fmt: skip
    for size in ("0mm", "-5mm", "nanmm", "1e999mm", "xmm"):
        svg = f"<svg width='{size}' height='{size}' viewBox='0 0 60 40'>{SQUARE}</svg>"
        yield _of(f"svg: {size} wide", svg, "d.svg", Right.EITHER)
    for box in ("0 0 0 0", "0 0 -1 -1", "x", "nan nan nan nan", "0 0 1e300 1e300"):
        svg = f"<svg width='60mm' height='40mm' viewBox='{box}'>{SQUARE}</svg>"
        yield _of(f"svg: a box of {box}", svg, "d.svg", Right.EITHER)


def _no_drawings() -> Iterator[Attempt]:
    for ending in ("svg", "dxf"):
        for name, content in {
            "empty": b"",
            "zeros": bytes(300),
            "binary": bytes(range(256)) * 4,
            "a text": b"hello\nworld\n",
            **NO_FILES,
        }.items():
            yield _of(f"{ending}: {name}", content, f"d.{ending}")
    for name, content in {
        "empty": b"",
        "a text": b"hello",
        "a pipe": os.mkfifo,
        "a folder": lambda path: path.mkdir(),
        "zeros without end": lambda path: path.symlink_to("/dev/zero"),
        "an svg": SVG.format(SQUARE),
        "of one pixel": _png(1, 1),
        "all white": _png(64, 2),
    }.items():
        right = Right.EITHER if name in ("of one pixel", "all white") else Right.REFUSED
        yield _image(f"image: {name}", content, right)
    bomb = bytearray(_png())
    bomb[16:24] = (60_000).to_bytes(4, "big") * 2
    yield _image("image: 60000 by 60000 promised", bytes(bomb), Right.REFUSED)


def _keys() -> Iterator[Attempt]:
    good = SVG.format(SQUARE)
    for key, values in {
        "layer": NO_CHOICE,
        "colour": NO_CHOICE,
        "what": NO_CHOICE,
        "unit": NO_CHOICE,
        "origin": NO_CHOICE,
        "tolerance": NO_LENGTH,
        "joint": NO_LENGTH,
        "kerf": NO_LENGTH,
        "dpi": NO_LENGTH,
    }.items():
        for label, value in values.items():
            harmless = label in ("unit 0 mm", "zero", "-0.0") and key in ("kerf", "joint")
            yield _of(f"{key}: {label}", good, "d.svg",
                      Right.EITHER if harmless else Right.REFUSED, **{key: value})  # fmt: skip
    for key in ("width", "smoothing", "least_area"):
        for label, value in NO_LENGTH.items():
            harmless = label in ("unit 0 mm", "zero", "-0.0") and key != "width"
            right = Right.EITHER if harmless else Right.REFUSED
            yield _image(f"image {key}: {label}", _png(), right, **{key: value})
    yield _of("an unknown key", good, "d.svg", drawin="x")
    yield _of("an ending of none", good, "d.txt")
    yield _of("no drawing at all", good, "d.svg", drawing="none.svg")
    yield _of("an absolute one of the system", good, "d.svg", drawing="/etc/passwd")
    yield _of("an address", good, "d.svg", drawing="http://127.0.0.1:9/d.svg")
