"""A clamped circular plate under a follower pressure, far into large deflections. SI units.

Its edge neither turns nor moves. Reference: von Karman's equations for a round plate (Way 1934;
Timoshenko and Woinowsky-Krieger, section 97), with Q = q a^4 / (E h^4), W = w / h, S = W' and
T = N a^2 / (E h^3) over the radius r / a:

    (S'' + S' / r - S / r^2) / (12 (1 - nu^2)) = T S + Q r / 2,    (r^3 T')' = -r S^2 / 2,

S = 0 at both ends, T' = 0 at the centre, T' + (1 - nu) T = 0 at the edge.
"""

from collections.abc import Iterator

import numpy as np
import xarray as xr
from scipy.integrate import solve_bvp

from bilayer import Disc, Layer, LinearElastic, Load, MeshSize, Part, Prestretch, Specimen, Support
from verification.rung import Check

WORDS = (
    "Its edge neither turns nor moves, nu = 0.3, h / a = 0.01. Von Karman's equations (Way 1934), "
    "solved here; the published tables differ from that by up to 2 %."
)
RADIUS, THICKNESS, YOUNG, POISSON = 0.02, 2e-4, 1e7, 0.3
LOADS = (1.0, 2.0, 6.0, 15.0, 30.0)
"""Q of the milestones."""
TABLE = {1.0: 0.169, 2.0: 0.323, 6.0: 0.761, 15.0: 1.279}
"""W of published tables, to three digits."""
FIRST = 1e-4
"""Radius at which the equations begin: they are singular at the centre."""


def plate_specimen(size: float) -> Specimen:
    """The plate as a specimen, on a mesh of a size."""
    pressure = [q * YOUNG * THICKNESS**4 / RADIUS**4 for q in LOADS]
    plate = Layer("plate", THICKNESS, LinearElastic(YOUNG, POISSON))
    return Specimen(
        Disc(RADIUS),
        [plate],
        Prestretch([1.0]),
        mesh=MeshSize(size),
        supports=[Support("rim", "clamped", Part("rim"))],
        loads=[Load("blow", "pressure", pressure)],
    )


def checks(result: xr.Dataset, case: str, tolerance: float | None) -> Iterator[Check]:
    """The deflections of the centre in a result, against von Karman's."""
    middle = np.argmin(np.linalg.norm(result["reference_position"].values, axis=1))
    found = result["position"].values[:, middle, 2] / THICKNESS
    for load, deflection in zip(LOADS, found, strict=True):
        quantity = f"{case}, q a^4 / E h^4 = {load:g}: w / h"
        yield Check(quantity, float(deflection), von_karman_deflection(load), tolerance)
        if tolerance is not None and load in TABLE:
            yield Check(f"{quantity}, tables", float(deflection), TABLE[load])


def von_karman_deflection(load: float, poisson_ratio: float = POISSON) -> float:
    """W at the centre under Q."""
    stiffness = 1 / (12 * (1 - poisson_ratio**2))

    def change(r, y):
        slope, bend, force, pull = y  # S, (S r)' / r, T, r^3 T'
        return np.array(
            [bend - slope / r, (force * slope + load * r / 2) / stiffness,
             pull / r**3, -r * slope**2 / 2]
        )  # fmt: skip

    def ends(first, last):
        return np.array(
            [first[0] - first[1] * FIRST / 2, first[3], last[0],
             last[3] + (1 - poisson_ratio) * last[2]]
        )  # fmt: skip

    r = np.linspace(FIRST, 1, 201)
    guess = np.zeros((4, len(r)))
    guess[0] = load / (16 * stiffness) * r * (r**2 - 1) / (1 + load / 10)
    guess[2] = load / 20
    found = solve_bvp(change, ends, r, guess, tol=1e-8, max_nodes=100_000)
    if not found.success:
        raise RuntimeError(found.message)
    r = np.linspace(FIRST, 1, 20_001)
    return float(abs(np.trapezoid(found.sol(r)[0], r)))
