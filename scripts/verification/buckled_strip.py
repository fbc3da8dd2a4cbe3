"""A strip buckled between clamps and pushed through at its middle, by the theory of beams.

Small slopes; shortening and axial compression included. References: Vangbo (1998), "An analytical
analysis of a compressed bistable buckled beam", Sensors and Actuators A 69. With the compression
N = E I k^2, t = k L / 2 and the force F at the middle, half of the strip deflects by

    w = A + B x + C cos k x + D sin k x,    D = -F / (2 E I k^3),  B = -D k,  C = -D tan(t / 2).

The shortening of the ends fixes D. The symmetric shape loses its stability where the antisymmetric
mode buckles, tan t = t. From there on k stays, and the force falls in proportion to the deflection,
through 0 to the mirror image.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from bilayer import (
    Layer,
    Limit,
    LinearElastic,
    Load,
    MeshSize,
    Part,
    Prestretch,
    Rectangle,
    Response,
    Specimen,
    Support,
    read_specimen,
)
from verification.rung import Check

FILE = Path(__file__).parents[2] / "examples" / "snapping_strip.toml"
WORDS = (
    "examples/snapping_strip.toml: force on the middle at imposed deflections, through both limit "
    "points, and the rise where it is free; beam theory with the same shortening (Vangbo 1998)."
)

ANTISYMMETRIC = 4.493409457909064
"""The first positive root of tan t = t: half of k L."""


@dataclass(frozen=True)
class BuckledStrip:
    """A strip without Poisson's effect, clamped at both ends.

    Parameters
    ----------
    length, width, thickness : float
        m.
    young_modulus : float
        Pa.
    shortening : float
        By which its ends are pushed together, m.
    """

    length: float
    width: float
    thickness: float
    young_modulus: float
    shortening: float

    @property
    def stiffness(self) -> float:
        """E I, N m2."""
        return self.young_modulus * self.width * self.thickness**3 / 12

    def symmetric_state(self, t: float) -> tuple[float, float]:
        """Deflection of the middle, upward, m, and the force along it, N, at t = k L / 2."""
        half, k = self.length / 2, 2 * t / self.length
        c = -np.tan(t / 2)
        x = np.linspace(0, half, 2001)
        slope = k * (-1 - c * np.sin(k * x) + np.cos(k * x))
        per_square = np.trapezoid(slope**2, x)
        compression = k**2 * self.thickness**2 / 12 * self.length
        d = np.copysign(1.0, t - np.pi) * np.sqrt((self.shortening - compression) / per_square)
        a = d * (k * half - c * np.cos(t) - np.sin(t))
        return float(a + d * c), float(-2 * self.stiffness * k**3 * d)

    @property
    def rise(self) -> float:
        """Deflection of the middle without a force, m."""
        return self.symmetric_state(np.pi * (1 + 1e-9))[0]

    @property
    def snap(self) -> tuple[float, float]:
        """Deflection, m, and force, N, where it begins to snap, of either sign."""
        return self.symmetric_state(ANTISYMMETRIC)

    def force_at(self, deflection: float) -> float:
        """Force on the middle that holds it at a deflection, N."""
        at, force = self.snap
        if abs(deflection) <= at:
            return force * deflection / at
        low, high = np.pi * (1 + 1e-9), ANTISYMMETRIC
        if abs(deflection) > self.rise:
            low, high = np.pi / 2, np.pi * (1 - 1e-9)
        t = brentq(lambda t: self.symmetric_state(t)[0] - abs(deflection), low, high)
        return float(np.copysign(1, deflection) * self.symmetric_state(t)[1])


STRIP = BuckledStrip(0.06, 0.006, 3e-4, 1e9, 3e-4)
"""The strip of the file."""


def specimen(size: float) -> Specimen:
    """The strip as a specimen, on a mesh of a size, m."""
    return read_specimen(FILE, [f"mesh.size={size}"])


COMPRESSED = BuckledStrip(0.0603, 0.006, 3e-4, 1e9, 3e-4)
"""A strip of the same shortening that is compressed when it is bonded, not by its clamps."""
POKES = (2.5e-3, "free", 1e-3, -1e-3, -2e-3, "free", 1e-3)


def compressed_specimen(size: float) -> Specimen:
    """Such a strip as a specimen, both ends clamped, on a mesh of a size, m."""
    law = LinearElastic(COMPRESSED.young_modulus, 0.0)
    layer = Layer("strip", COMPRESSED.thickness, law, response=Response("path"))
    half = (COMPRESSED.length - COMPRESSED.shortening) / 2
    ends = {
        name: Part("rim", (Limit("x", relation, bound),))
        for name, relation, bound in (("left", "<=", -half), ("right", ">=", half))
    }
    middle = Part(line=((0.0, -COMPRESSED.width / 2), (0.0, COMPRESSED.width / 2)))
    return Specimen(
        Rectangle(2 * half, COMPRESSED.width),
        [layer],
        Prestretch([(2 * half / COMPRESSED.length, 1.0)]),
        mesh=MeshSize(size),
        supports=[Support(name, "clamped", part) for name, part in ends.items()],
        loads=[Load("poke", "displacement", POKES, middle)],
    )


def checks(
    result: xr.Dataset, case: str, tolerance: float | None, strip: BuckledStrip = STRIP
) -> Iterator[Check]:
    """Forces and rises of a result against the theory."""
    rows = (result[name].values for name in ("load_poke", "response_poke", "displacement_poke"))
    for wanted, force, reached in zip(*rows, strict=True):
        if np.isnan(wanted):
            rise = f"{case}, free: rise (m)"
            yield Check(rise, abs(float(reached)), strip.rise, tolerance)
        else:
            quantity = f"{case}, deflection {1e3 * wanted:g} mm: force (N)"
            yield Check(quantity, float(force), strip.force_at(float(wanted)), tolerance)
