"""A circular Mooney-Rivlin sheet, thin and clamped all around, blown up like a balloon. SI units.

At the pole it is stretched alike in all directions, by l, and round, with the radius of curvature
rho. Equilibrium there (Adkins and Rivlin 1952), h the natural thickness:

    p = 4 h / rho (1 - l^-6) (C10 + l^2 C01).
"""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from bilayer import Disc, Layer, Load, MeshSize, MooneyRivlin, Part, Prestretch, Specimen, Support
from verification.rung import Check

WORDS = (
    "Radius 20 mm, 0.2 mm thick, incompressible, clamped all around. Equilibrium of an equibiaxial "
    "membrane at the pole (Adkins and Rivlin 1952), its stretch and radius of curvature fitted to "
    "the nodes within a quarter of the radius."
)
RADIUS, THICKNESS = 0.02, 2e-4
LAW = MooneyRivlin(4839.1, 14536.0)
PRESSURES = (50.0, 150.0, 300.0)
NEAR = 0.25
"""Part of the radius within which the pole is fitted."""


def membrane_specimen(size: float) -> Specimen:
    """The sheet as a specimen, on a mesh of a size."""
    return Specimen(
        Disc(RADIUS),
        [Layer("sheet", THICKNESS, LAW)],
        Prestretch([1.0]),
        mesh=MeshSize(size),
        supports=[Support("rim", "clamped", Part("rim"))],
        loads=[Load("blow", "pressure", PRESSURES)],
    )


def rises(result: xr.Dataset) -> list[float]:
    """The height of the pole over the rim at each pressure, m."""
    middle = np.argmin(np.linalg.norm(result["reference_position"].values, axis=1))
    return [float(z) for z in result["position"].values[:, middle, 2]]


def pole_pressure(flat: np.ndarray, shape: np.ndarray) -> float:
    """The pressure that the pole's stretch and curvature balance, Pa."""
    near = np.linalg.norm(flat, axis=1) < NEAR * RADIUS
    r, x = np.linalg.norm(flat[near], axis=1), shape[near]
    outward = np.linalg.norm(x[:, :2] - x[np.argmin(r), :2], axis=1)
    stretch = np.linalg.lstsq(np.column_stack([r, r**3]), outward, rcond=None)[0][0]
    columns = np.column_stack([np.ones_like(outward), outward**2, outward**4])
    curvature = -2 * np.linalg.lstsq(columns, x[:, 2], rcond=None)[0][1]
    modulus = LAW.c10 + stretch**2 * LAW.c01
    return float(4 * THICKNESS * curvature * (1 - stretch**-6) * modulus)


def checks(result: xr.Dataset, case: str, tolerance: float | None) -> Iterator[Check]:
    """The pole of a result against its equilibrium."""
    flat = result["reference_position"].values[:, :2]
    for pressure, shape in zip(PRESSURES, result["position"].values, strict=True):
        quantity = f"{case}, {pressure:g} Pa: pressure that the pole balances (Pa)"
        yield Check(quantity, pole_pressure(flat, shape), pressure, tolerance)
