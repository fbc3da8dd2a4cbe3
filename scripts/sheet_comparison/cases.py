"""The sheets that both solvers compute, thin and thick, and as published."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from bilayer import (
    Cross,
    CutPattern,
    Disc,
    Ellipse,
    Layer,
    MeshSize,
    MooneyRivlin,
    Prestretch,
    Rectangle,
    Response,
    Specimen,
)
from bilayer.specimen.pattern import Pattern

STRETCHED = MooneyRivlin(22060.0, 1656.0, 1e-5)
CUT = MooneyRivlin(17880.0, 84450.0, 1e-5)
THICKNESS = {"substrate": 1.1e-3, "kirigami": 1.6e-3}
"""Natural, of the bistable sheets that the constants are published for, m."""

SHEETS = {
    "square": (Rectangle(0.04, 0.04), None, 2.5e-3),
    "ellipse": (Ellipse(0.056, 0.028), None, 2.5e-3),
    "cross on a square": (Rectangle(0.04, 0.04), Cross(3.3e-3), 2e-3),
    "lotus of 10 petals": (
        Disc(0.02),
        CutPattern(10, 0.55 * 0.02, 0.4 * 2 * np.pi / 10),
        2.5e-3,
    ),
}
"""Outline, pattern of the kirigami and mesh size, m."""
PILES = {"bilayer": ("substrate", "kirigami"), "trilayer": ("lower", "substrate", "upper")}
SHARES = (0.05, 0.1, 0.2, 0.02)
"""Thicknesses of all layers together, over the characteristic length."""
FULL_SIZE = 0.04
"""Sheets that are thinner than this have a finer mesh in proportion, as they bend more."""
FINER = 0.7
"""Mesh size of a repetition over the one before."""
MOST_TRIANGLES = 9500
"""Of a repetition: what the finite-element model does in a quarter of an hour."""
MILESTONES, FARTHEST = (1.03, 1.06), 1.2
THIN, TOLERANCE = 0.05, 0.005
"""Up to this thickness and up to the last of the milestones the solvers must agree so well."""


@dataclass(frozen=True)
class Case:
    """A sheet on a mesh.

    Parameters
    ----------
    sheet, pile : str
        Names in `SHEETS` and `PILES`.
    share : float or None
        Thickness of all layers together over the characteristic length; None: as published.
    repetitions : int
        How often the mesh was made finer.
    """

    sheet: str
    pile: str
    share: float | None
    repetitions: int = 0

    @property
    def specimen(self) -> Specimen:
        """Return the sheet with its mesh size and milestones."""
        outline, pattern, size = SHEETS[self.sheet]
        layers = [_layer(name, pattern) for name in PILES[self.pile]]
        if self.share is not None:
            full = sum(layer.thickness for layer in layers)
            scale = self.share * outline.characteristic_length / full
            layers = [replace(layer, thickness=scale * layer.thickness) for layer in layers]
            size *= min(1.0, self.share / FULL_SIZE)
        milestones = [*MILESTONES, FARTHEST] if self.share is None else MILESTONES
        size *= FINER**self.repetitions
        return Specimen(outline, layers, Prestretch(milestones), MeshSize(size), name=self.sheet)

    @property
    def is_thin(self) -> bool:
        """Return whether the solvers must agree on it."""
        return self.share is not None and self.share <= THIN

    @property
    def finer(self) -> "Case":
        """Return the case on the next finer mesh."""
        return replace(self, repetitions=self.repetitions + 1)

    @property
    def file_name(self) -> str:
        """Return a name for files of the case, without an ending."""
        thickness = "published" if self.share is None else f"{self.share:g}"
        size = 1e3 * self.specimen.mesh.size
        return f"{self.sheet} {self.pile} {thickness} {size:.3g} mm".replace(" ", "_")


def cases() -> Iterator[Case]:
    """Yield all cases on their first mesh, those as published first."""
    for share in (None, *SHARES):
        for sheet in SHEETS:
            for pile in PILES:
                yield Case(sheet, pile, share)


def softened(specimen: Specimen, softer: float) -> Specimen:
    """Return a sheet whose kirigami has smaller moduli by a share."""
    left = 1 - softer
    soft = MooneyRivlin(left * CUT.c10, left * CUT.c01, CUT.d1 / left)
    layers = [
        replace(layer, material=soft) if layer.material == CUT else layer
        for layer in specimen.layers
    ]
    return replace(specimen, layers=layers)


def _layer(name: str, pattern: Pattern | None) -> Layer:
    if name == "substrate":
        return Layer(name, THICKNESS[name], STRETCHED, response=Response("path"))
    return Layer(name, THICKNESS["kirigami"], CUT, pattern=pattern)
