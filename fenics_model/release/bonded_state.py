"""The flat bonded state of a layer as a state of the solid: in plane stress, alone."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from bilayer.mechanics.stress import cauchy_stress
from bilayer.specimen.layer import Layer, Tensor
from bilayer.specimen.materials import Hyperelastic

Array = NDArray[np.float64]

VOLUMES = (0.5, 2.0)
"""Between them lies the volume of a layer in the flat bonded state, over the natural one."""


def bonded_volume_and_pressure(layer: Layer, stretch: Tensor) -> tuple[float, float]:
    """Return the volume of a flat bonded layer over the natural one, and its pressure, Pa.

    The pressure is the one of plane stress. A hyperelastic layer has the volume J at which it is
    U'(J); with D1 = 0 that is 1. The linear law counts its strain from a volume of 1.

    Parameters
    ----------
    layer : Layer
        With its law.
    stretch : ((float, float), (float, float))
        U, from the natural state to the bonded one, in the plane.

    Examples
    --------
    >>> from bilayer import paper_specimen
    >>> layer = paper_specimen().layer("substrate")
    >>> volume, pressure = bonded_volume_and_pressure(layer, ((1.06, 0.0), (0.0, 1.06)))
    >>> 1 < volume < 1.01 and pressure > 0
    True
    """
    law, volume = layer.material, 1.0
    if isinstance(law, Hyperelastic) and law.d1 > 0:
        volume = brentq(lambda J: _pressure(law, stretch, J) - 2 * (J - 1) / law.d1, *VOLUMES,
                        xtol=1e-15, rtol=1e-14)  # fmt: skip
    return volume, _pressure(law, stretch, volume)


def _pressure(law: Any, stretch: Tensor, volume: float) -> float:
    """Return the mean of the principal stresses in plane stress at a volume, Pa."""
    in_plane = np.array(stretch)
    area = float(np.linalg.det(in_plane))
    prestretch, C = np.eye(3), np.eye(3)
    prestretch[:2, :2], prestretch[2, 2] = in_plane, 1 / area
    C[:2, :2], C[2, 2] = in_plane @ in_plane, (volume / area) ** 2
    return float(np.trace(cauchy_stress(law, C, prestretch, None)) / 3)
