"""Homogeneous states of a law in plane stress, as the shell has it. SI units."""

import numpy as np

from dshell.materials.plane_stress import plane_stress_law


def second_piola(law, stretches) -> np.ndarray:
    """Stress along the two axes of a sheet that is stretched along them, per natural area."""
    strain = np.array([[(x * x - 1) / 2] for x in stretches] + [[0.0]])
    stress = plane_stress_law(law).at(strain, np.eye(2)[:, :, None]).stress()
    assert stress[2, 0] == 0
    return stress[:2, 0]


def uniaxial_stress(law, stretch: float) -> float:
    """Nominal stress of a strip whose edges along are free."""
    along, across = second_piola(law, (stretch, stretch**-0.5))
    assert abs(across) < 1e-7 * abs(along), across
    return stretch * along


def equibiaxial_stress(law, stretch: float) -> float:
    """Cauchy stress of a sheet that is stretched equally in both directions."""
    return stretch**2 * second_piola(law, (stretch, stretch))[0]


def planar_stress(law, stretch: float) -> tuple[float, float]:
    """Nominal stresses, along and across, of a sheet whose width is held."""
    along, across = second_piola(law, (stretch, 1.0))
    return stretch * along, across
