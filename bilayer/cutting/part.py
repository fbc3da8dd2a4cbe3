"""The part to cut for each layer: its region before it is stretched."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.affinity import affine_transform

from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen


@dataclass(frozen=True)
class Part:
    """What is cut out of the stock of one layer.

    Parameters
    ----------
    layer : str
        Name of the layer.
    stretched : Polygon or MultiPolygon
        As it is bonded, m.
    relaxation : ndarray, shape (2, 2)
        What takes a point of the bonded part to its place before it is stretched.
    """

    layer: str
    stretched: shapely.Geometry
    relaxation: NDArray[np.float64]

    @cached_property
    def region(self) -> shapely.Geometry:
        """As it is cut, before it is stretched, m."""
        return affine_transform(self.stretched, [*self.relaxation.ravel(), 0.0, 0.0])

    @property
    def size(self) -> tuple[float, float]:
        """Width and height as cut, m."""
        return _size(self.region)

    @property
    def stretched_size(self) -> tuple[float, float]:
        """Width and height as bonded, m: what the frame that holds it stretched has to span."""
        return _size(self.stretched)

    @property
    def is_stretched(self) -> bool:
        """Whether it is stretched before it is bonded."""
        return not np.allclose(self.size, self.stretched_size, rtol=1e-9)


def part_of(specimen: Specimen, layer: str, stretch: StretchPair) -> Part:
    """Return the part of one layer.

    Parameters
    ----------
    specimen : Specimen
        Whose layer it is.
    layer : str
        Its name.
    stretch : (float, float)
        Prestretch (lambda_x, lambda_y) at which it is bonded. A stretched layer is cut smaller, by
        the inverse of its stretch.

    Examples
    --------
    >>> import bilayer
    >>> substrate = part_of(bilayer.paper_specimen(), "substrate", (1.25, 1.25))
    >>> [round(1e3 * length, 3) for length in substrate.size]
    [64.0, 64.0]
    """
    bonded = specimen.region_of(layer)
    stretches = np.array(specimen.layer(layer).response.tensor(stretch))
    return Part(layer, bonded, np.asarray(np.linalg.inv(stretches), dtype=np.float64))


def _size(region: shapely.Geometry) -> tuple[float, float]:
    x, y, far_x, far_y = region.bounds
    return far_x - x, far_y - y
