"""All that is measured of the shape at a milestone."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.contact.self_contact import self_contact_gap
from bilayer.contact.skin import BondedBody
from bilayer.measures.shape import ShapeMeasures, measure_shape
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen


@dataclass(frozen=True)
class Measures:
    """Measures of the shape at a milestone.

    Parameters
    ----------
    shape : ShapeMeasures
        Of the reference surface.
    self_contact_gap : float
        Smallest distance of the body from itself where it is bent back, m; 0 touching, infinite
        beyond one thickness.
    """

    shape: ShapeMeasures
    self_contact_gap: float

    @classmethod
    def undefined(cls) -> "Measures":
        """Return the measures of a shape that there is not: NaN."""
        return cls(ShapeMeasures.undefined(), math.nan)


def measure(
    specimen: Specimen,
    mesh: PlanarMesh,
    stretch: tuple[float, float],
    position: NDArray[np.float64],
) -> Measures:
    """Return the measures of a shape.

    Parameters
    ----------
    specimen, mesh
        What was released, on which planar mesh.
    stretch : (float, float)
        (lambda_x, lambda_y) of its prestretch.
    position : (n, 3) array of float
        The reference surface, m.
    """
    body = BondedBody.of(specimen, mesh, stretch)
    return Measures(
        measure_shape(mesh, position, specimen.characteristic_length),
        self_contact_gap(body, position),
    )
