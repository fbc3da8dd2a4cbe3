"""Pictures of heights, and how similar two of them are: the measure of published inverse designs.

The measure is the structural similarity SSIM (Wang, Bovik, Sheikh and Simoncelli, IEEE Transactions
on Image Processing 13, 600, 2004: Gaussian window of 1.5 pixels, K1 = 0.01, K2 = 0.03), whose range
is here that of the target's heights. Beside the shape there are that of a plain cap of the target's
area and height, and of the flat sheet, each at its place of least distance: a measure that does not
tell these from the shape says little.
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from bilayer.designing.distance import TargetDistance
from bilayer.designing.targets import cap
from bilayer.geometry.surface import Surface

Array = NDArray[np.float64]

PIXELS = 256
MARGIN = 1.3
"""Width of the picture, over that of the target: that of published pictures, 60 mm of 46."""
WINDOW, REACH = 1.5, 3.5
"""Of the Gaussian window: standard deviation in pixels, and where it ends, over that."""
K1, K2 = 0.01, 0.03


@dataclass(frozen=True)
class Similarity:
    """SSIM with the heights of a target.

    Parameters
    ----------
    shape, plain_cap, flat : float
        Of a shape, of a cap of the target's area and height, and of the sheet that was never
        released.
    """

    shape: float
    plain_cap: float
    flat: float


def similarity(target: Surface, shape: Surface, sheet: Surface) -> Similarity:
    """Return how similar a shape, a plain cap and the flat sheet are to a target seen from above.

    Parameters
    ----------
    target, shape, sheet : Surface
        Each in axes of its own, m. The target is seen along its z axis.
    """
    distance = TargetDistance(target)
    window = _Window.on(target)
    wanted = window.picture(target)

    def of(surface: Surface) -> float:
        place = distance.measure_anew(surface).place
        there = window.picture(Surface(place.bring(surface.points), surface.triangles))
        return structural_similarity(wanted, there, float(np.ptp(target.points[:, 2])))

    return Similarity(of(shape), of(plain_cap(target)), of(sheet))


def plain_cap(target: Surface) -> Surface:
    """Return the spherical cap of the area and the height of a target.

    Its area is pi (a^2 + h^2), with the rim's radius a and the height h.
    """
    height = float(np.ptp(target.points[:, 2]))
    rim = math.sqrt(max(target.areas.sum() / math.pi - height**2, 0.0))
    radius = (rim**2 + height**2) / (2 * height)
    return cap(radius, math.acos(1 - height / radius))


def structural_similarity(first: Array, second: Array, span: float) -> float:
    """Return the mean SSIM of two pictures.

    Parameters
    ----------
    first, second : (n, m) array of float
        The pictures.
    span : float
        Range of their values.

    Examples
    --------
    >>> picture = np.add.outer(np.arange(32.0), np.arange(32.0))
    >>> round(structural_similarity(picture, picture, 62.0), 12)
    1.0
    """

    def blurred(picture: Array) -> Array:
        return np.asarray(scipy.ndimage.gaussian_filter(picture, WINDOW, truncate=REACH))

    a, b = blurred(first), blurred(second)
    own, others = blurred(first**2) - a**2, blurred(second**2) - b**2
    shared = blurred(first * second) - a * b
    c1, c2 = (K1 * span) ** 2, (K2 * span) ** 2
    similar = (2 * a * b + c1) * (2 * shared + c2)
    similar /= (a**2 + b**2 + c1) * (own + others + c2)
    edge = round(REACH * WINDOW)  # where the window leaves the picture
    return float(similar[edge:-edge, edge:-edge].mean())


@dataclass(frozen=True, eq=False)
class _Window:
    """A square seen from above; where no surface is, the height is that of the ground.

    Parameters
    ----------
    corner : (2,) array of float
        Least x and y, m.
    pixel : float
        m.
    ground : float
        z, m: the lowest of the target.
    """

    corner: Array
    pixel: float
    ground: float

    @classmethod
    def on(cls, target: Surface) -> "_Window":
        low, high = target.points.min(axis=0), target.points.max(axis=0)
        width = MARGIN * float((high - low)[:2].max())
        centre = (low + high)[:2] / 2
        return cls(centre - width / 2, width / PIXELS, float(low[2]))

    def picture(self, surface: Surface) -> Array:
        """Return the greatest height above the ground in each pixel, m, (PIXELS, PIXELS)."""
        points = self._samples(surface)
        places = np.floor((points[:, :2] - self.corner) / self.pixel).astype(np.int64)
        inside = ((places >= 0) & (places < PIXELS)).all(axis=1)
        heights = np.zeros((PIXELS, PIXELS))
        x, y = places[inside].T
        np.maximum.at(heights, (y, x), points[inside, 2] - self.ground)
        return heights

    def _samples(self, surface: Surface) -> Array:
        """Return points on a surface, no pixel apart, (k, 3)."""
        corners = surface.corners
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()
        count = max(2, math.ceil(1.5 * longest / self.pixel))
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        kept = i + j <= count
        shares = np.column_stack([i[kept], j[kept], count - i[kept] - j[kept]]) / count
        return np.asarray(np.einsum("pc,tcx->tpx", shares, corners).reshape(-1, 3))
