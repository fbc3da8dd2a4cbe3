"""The sheets: a lotus and a cross on both sides of a substrate, the outer layers thick or thin."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import bilayer

EXAMPLES = Path(__file__).parents[2] / "examples"
LOTUS, CROSS = "lotus", "cross"
SHARES = (1.0, 0.25)
"""Thickness of the outer layers over the published one."""
MILESTONES = (1.1, 1.2, 1.3)
PUBLISHED = 1.2
"""Prestretch of the published sheets: there the finite-element model is asked, too."""


@dataclass(frozen=True)
class Case:
    """A sheet at a prestretch.

    Parameters
    ----------
    sheet : str
        `LOTUS` or `CROSS`.
    share : float
        Thickness of the outer layers over the published one.
    prestretch : float
        Of the substrate.
    scale : float
        Of the mesh, see `trilayer`.
    """

    sheet: str
    share: float
    prestretch: float
    scale: float = 1.0

    @property
    def specimen(self) -> bilayer.Specimen:
        """The sheet, with the prestretch as its milestone."""
        sheet = trilayer(self.sheet, self.share, self.scale)
        return sheet.with_milestones([self.prestretch])

    def __str__(self) -> str:
        return f"{self.sheet}_{self.share:g}_{self.prestretch:g}"


def cases(scale: float = 1.0) -> Iterator[Case]:
    """Yield the cases, the published prestretch of each sheet first."""
    for stretch in sorted(MILESTONES, key=lambda value: (value != PUBLISHED, value)):
        for share in SHARES:
            for sheet in (LOTUS, CROSS):
                yield Case(sheet, share, stretch, scale)


def trilayer(sheet: str, share: float, scale: float = 1.0) -> bilayer.Specimen:
    """Return a published sheet with outer layers of a share of their thickness.

    Its mesh is of 3 mm (lotus) or 3.75 mm, 1.5 mm at the corners (cross), times the scale.
    """
    if sheet == LOTUS:
        size = [f"mesh.size={3 * scale} mm"]
        whole = bilayer.read_specimen(EXAMPLES / "trilayer_lotus.toml", size)
    else:
        size = [f"mesh.size={3.75 * scale} mm", f"mesh.corner_size={1.5 * scale} mm"]
        whole = on_both_sides(bilayer.read_specimen(EXAMPLES / "square_cross.toml", size))
    for layer in (whole.layers[0], whole.layers[-1]):
        whole = whole.with_layer(layer.name, thickness=share * layer.thickness)
    return whole


def on_both_sides(sheet: bilayer.Specimen) -> bilayer.Specimen:
    """Return a bilayer with its upper layer below the substrate, too."""
    substrate, upper = sheet.layers
    return replace(sheet, layers=(replace(upper, name="lower"), substrate, upper))
