"""A specimen as a notebook shows it: a drawing of the flat sheet, and its layers with units."""

import html
from typing import Any

import shapely

from bilayer.specimen.layer import Layer
from bilayer.specimen.outline import rings_of

SIDE = 160
"""Of the drawing, pixels."""
COLOURS = ("#EEBB44", "#4477AA", "#228833", "#AA3377", "#66CCEE")
"""Of the layers from the bottom up, see-through."""


def specimen_html(specimen: Any) -> str:
    """Return a specimen as HTML that needs no other file.

    Parameters
    ----------
    specimen : Specimen
        Its class imports this module. Names in it are shown as text.
    """
    rows = "".join(_row(layer, colour) for layer, colour in _coloured(specimen))
    milestones = ", ".join(_stretch(pair) for pair in specimen.prestretch.milestones)
    lines = [
        f"<b>{html.escape(specimen.name)}</b>: {html.escape(specimen.outline.words)}",
        f"prestretch {milestones}",
        f"mesh size {1e3 * specimen.mesh.size:g} mm",
    ]
    if specimen.gravity:
        lines.append(f"weight, {specimen.gravity:g} m/s²")
    head = "".join(
        f"<th>{title}</th>"
        for title in ("layer, from the top", "thickness", "material", "Young's modulus",
                      "Poisson's ratio", "lies on")
    )  # fmt: skip
    return (
        '<div style="display:flex;gap:1.5em;align-items:center">'
        f"{_drawing(specimen)}<div>{'<br>'.join(lines)}"
        f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div></div>"
    )


def _coloured(specimen: Any) -> list[tuple[Layer, str]]:
    """Return the layers from the top down, each with its colour."""
    upward = [(layer, COLOURS[k % len(COLOURS)]) for k, layer in enumerate(specimen.layers)]
    return upward[::-1]


def _row(layer: Layer, colour: str) -> str:
    material = layer.material
    stretched = ", stretched" if layer.is_stretched else ""
    cells = (
        f'<span style="color:{colour}">&#9632;</span> {html.escape(layer.name)}{stretched}',
        f"{1e3 * layer.thickness:g} mm",
        html.escape(material.name),
        f"{material.young_modulus / 1e3:.4g} kPa",
        f"{material.poisson_ratio:.3g}",
        "the whole sheet" if layer.pattern is None else html.escape(layer.pattern.words),
    )
    return f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def _stretch(pair: tuple[float, float]) -> str:
    return f"{pair[0]:g}" if pair[0] == pair[1] else f"{pair[0]:g} × {pair[1]:g}"


def _drawing(specimen: Any) -> str:
    """Return the flat sheet as SVG, y up: each layer where it lies."""
    left, low, right, high = specimen.sheet.bounds
    size = max(right - left, high - low)
    margin = 0.03 * size
    frame = f"{left - margin:.6g} {-high - margin:.6g} {size + 2 * margin:.6g}"
    layers = "".join(
        f'<path d="{_path(specimen.region_of(layer.name))}" fill="{colour}" fill-opacity="0.75" '
        f'fill-rule="evenodd" stroke="#333" stroke-width="{size / 300:.3g}"/>'
        for layer, colour in reversed(_coloured(specimen))
    )
    return (
        f'<svg width="{SIDE}" height="{SIDE}" viewBox="{frame} {size + 2 * margin:.6g}" '
        f'role="img" aria-label="flat sheet">{layers}</svg>'
    )


def _path(region: shapely.Geometry) -> str:
    """Return the edges of a region as the data of an SVG path."""
    return " ".join(
        "M" + " L".join(f"{x:.6g},{-y:.6g}" for x, y in ring) + " Z" for ring in rings_of(region)
    )
