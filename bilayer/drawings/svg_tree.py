"""The elements of an SVG file, rewritten where svgelements reads them as something else."""

import copy
import re
from xml.etree.ElementTree import Element

from bilayer.errors import InputError

NAMESPACE = "{http://www.w3.org/2000/svg}"
LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
LINKS = ("href", "{http://www.w3.org/1999/xlink}href")
GROUPS = "data-groups"
"""The attribute in which an element is given the names of the groups around it."""
SEPARATOR = "\u241f"
OF_A_RECT = ("x", "y", "width", "height")
"""Lengths that are 0 if a rectangle leaves them out."""
MEASURES = (*OF_A_RECT, "r", "rx", "ry", "cx", "cy", "x1", "y1", "x2", "y2")
NOT_DRAWN = tuple(f"{NAMESPACE}{kind}" for kind in ("clipPath", "marker", "mask", "pattern"))
LENGTHS = {
    "mm": 1e-3, "cm": 1e-2, "in": 0.0254, "pt": 0.0254 / 72, "pc": 0.0254 / 6, "q": 0.25e-3,
}  # fmt: skip
"""m. A pixel is not among them: 1/96 inch by CSS, 1/72 for some programs."""
PIXEL = 0.0254 / 96
"""What CSS takes a user unit for where a length of a shape has a unit, m."""
MOST_COPIES = 10_000
"""Of symbols: a small file may stand for many."""


def prepare(root: Element) -> None:
    """Rewrite what svgelements leaves out, takes twice or takes from elsewhere.

    Raises
    ------
    InputError
        A length or a place depends on what the file does not say.
    """
    for element in root.iter():
        _check_origin(element)
        _write_lengths(element)
        _show(element)
    _name_groups(root, ())
    _write_symbols_out(root)
    _set_aside_what_is_not_drawn(root)


def _check_origin(element: Element) -> None:
    styled = re.search(r"transform-origin\s*:\s*([^;]+)", element.get("style", ""))
    origin = element.get("transform-origin") or (styled[1] if styled else "0")
    moved = element.get("transform") or "transform:" in element.get("style", "").replace(" ", "")
    if moved and not re.fullmatch(r"[\s0.,]*(px)?[\s0.,]*(px)?\s*", origin):
        raise InputError(
            f"transform-origin = {origin.strip()!r} of a {_kind(element)}: expected transforms "
            "about the origin, as most programs write them"
        )


def _write_lengths(element: Element) -> None:
    """Write lengths with a unit in user units, in full precision, and those that are left out."""
    for name in MEASURES:
        text = element.get(name, "").strip()
        if re.fullmatch(r"[-+.\deE]+(r?em|ex|ch|v[wh])", text):
            raise InputError(
                f"{name} = {text!r} of a {_kind(element)}: expected a number or a length in mm"
            )
        parts = re.fullmatch(r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*([a-zA-Z]+)", text)
        if parts and parts[2].lower() in LENGTHS:
            element.set(name, repr(float(parts[1]) * (LENGTHS[parts[2].lower()] / PIXEL)))
    if element.tag == f"{NAMESPACE}rect":  # svgelements takes those of an svg around it
        element.attrib |= {name: element.get(name, "0") for name in OF_A_RECT}


def _show(element: Element) -> None:
    """Write what is not displayed as hidden: svgelements leaves it out, layers and all."""
    if element.get("display", "").strip() == "none":
        element.attrib |= {"display": "inline", "visibility": "hidden"}
    if "style" in element.attrib:
        shown = re.sub(r"\bdisplay\s*:\s*none\b", "visibility:hidden", element.attrib["style"])
        element.set("style", shown)


def _name_groups(element: Element, names: tuple[str, ...]) -> None:
    """Give each element the labels (Inkscape) and ids of all groups around it, and its own."""
    own = (element.get(LABEL), element.get("id"))
    if element.tag != f"{NAMESPACE}svg":
        names = (*names, *(name for name in own if name))
    element.set(GROUPS, SEPARATOR.join(names))
    for child in element:
        _name_groups(child, names)


def _write_symbols_out(root: Element) -> None:
    """Replace each use of a symbol with a viewBox by an svg, whose viewBox svgelements knows."""
    symbols = {
        f"#{symbol.get('id')}": symbol
        for symbol in root.iter(f"{NAMESPACE}symbol")
        if symbol.get("viewBox")
    }
    if not symbols:
        return
    copies = 0
    for parent in list(root.iter()):
        for place, child in enumerate(parent):
            symbol = symbols.get(next(filter(None, map(child.get, LINKS)), ""))
            if child.tag == f"{NAMESPACE}use" and symbol is not None:
                copies += 1
                parent[place] = _written_out(child, symbol)
    if copies > MOST_COPIES:
        raise InputError(f"has {copies} symbols, expected at most {MOST_COPIES}")


def _written_out(use: Element, symbol: Element) -> Element:
    """Return a group with the svg that a use of a symbol stands for."""
    around = {name: text for name, text in use.attrib.items() if name not in (*OF_A_RECT, *LINKS)}
    box = symbol.get("viewBox", "").replace(",", " ").split()
    size = dict(zip(("width", "height"), box[2:], strict=False))
    inner = Element(f"{NAMESPACE}svg", {"x": "0", "y": "0", **size, "viewBox": " ".join(box)})
    inner.attrib |= {name: use.attrib[name] for name in OF_A_RECT if name in use.attrib}
    if "preserveAspectRatio" in symbol.attrib:
        inner.set("preserveAspectRatio", symbol.attrib["preserveAspectRatio"])
    inner.extend(copy.deepcopy(child) for child in symbol)
    group = Element(f"{NAMESPACE}g", around)
    group.append(inner)
    return group


def _set_aside_what_is_not_drawn(root: Element) -> None:
    """Take out masks and the like, and put symbols where `use` alone finds them."""
    symbols = Element(f"{NAMESPACE}defs")
    root.insert(0, symbols)
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag in NOT_DRAWN:
                parent.remove(child)
            elif child.tag == f"{NAMESPACE}symbol" and parent is not symbols:
                parent.remove(child)
                symbols.append(child)


def _kind(element: Element) -> str:
    return str(element.tag).removeprefix(NAMESPACE)
