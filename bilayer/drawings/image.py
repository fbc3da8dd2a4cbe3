"""The contours of an image: its dark or its light parts, edges smoothed to a stated length."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.drawings.lines import Points
from bilayer.drawings.packages import package
from bilayer.errors import InputError

FORMATS = ("PNG", "JPEG", "TIFF", "BMP", "GIF", "WEBP", "PPM")
"""Those that Pillow reads by itself, told by the content: for EPS it starts Ghostscript."""
MOST_PIXELS = 50_000_000
SHADES = ("dark", "light")


@dataclass(frozen=True)
class ImageSource:
    """An image and how its parts are found.

    Parameters
    ----------
    path : Path
        A file in a format that Pillow reads.
    width : float
        From the image's left edge to the right one, m.
    shade : {"dark", "light"}
        The parts that are meant.
    threshold : float
        Between them, from 0 (black) to 1 (white).
    smoothing : float
        Standard deviation of the blur (of a normal distribution) with which edges are smoothed, m;
        0: none.
    least_area : float
        Smaller parts and smaller holes are dropped, m2.
    """

    path: Path
    width: float
    shade: str = "dark"
    threshold: float = 0.5
    smoothing: float = 0.0
    least_area: float = 0.0

    def contours(self) -> tuple[list[Points], int]:
        """Return the contours around the image's centre, y upwards, m, and the number dropped.

        Raises
        ------
        InputError
            The file cannot be read, or nothing is left.
        """
        contourpy = package("contourpy")
        shades = _shades(self.path)
        rows, columns = shades.shape
        pixel = self.width / columns
        meant = shades < self.threshold if self.shade == "dark" else shades >= self.threshold
        # a rim of what is not meant closes the contours at the image's edges
        field = np.pad(meant.astype(float), 1)
        if self.smoothing > 0:
            from scipy.ndimage import gaussian_filter  # seldom needed, slow to load

            field = np.asarray(gaussian_filter(field, self.smoothing / pixel))
        lines = contourpy.contour_generator(z=field).lines(0.5)
        centre = np.array([columns + 1, rows + 1]) / 2
        rings = [pixel * (line[:-1] - centre) * [1, -1] for line in lines if len(line) > 3]
        kept = [ring for ring in rings if shapely.Polygon(ring).area > self.least_area]
        if not kept:
            raise InputError(
                f"image = {self.path.name!r}: no part is {self.shade} at threshold "
                f"{self.threshold:g} and larger than {1e6 * self.least_area:g} mm2"
            )
        return kept, len(rings) - len(kept)


def _shades(path: Path) -> NDArray[np.float64]:
    """Return the grey values of an image on white paper, from 0 to 1."""
    image = package("PIL.Image")
    try:
        with image.open(path, formats=FORMATS) as opened:
            width, height = opened.size
            if width * height > MOST_PIXELS:
                raise InputError(
                    f"image = {str(path)!r}: has {width} x {height} pixels, expected at most "
                    f"{MOST_PIXELS:.0e} in all"
                )
            if opened.mode.startswith(("I", "F")):
                return _deep_shades(path, opened)
            paper = image.new("RGBA", opened.size, "white")
            paper.alpha_composite(opened.convert("RGBA"))
            return np.asarray(paper.convert("L"), dtype=float) / 255
    except InputError:
        raise
    except (OSError, ValueError, SyntaxError, image.DecompressionBombError) as error:
        reason = getattr(error, "strerror", None) or "not an image"
        raise InputError(f"image = {str(path)!r}: cannot be read ({reason})") from error


def _deep_shades(path: Path, opened: Any) -> NDArray[np.float64]:
    """Return the grey values of an image of more than 8 bits, which Pillow would cut off at 255."""
    white = 1.0 if opened.mode.startswith("F") else 65535.0
    values = np.asarray(opened, dtype=float)
    if not (values.min() >= 0 and values.max() <= white):
        raise InputError(
            f"image = {str(path)!r}: has values from {values.min():g} to {values.max():g}, "
            f"expected from 0 (black) to {white:g} (white)"
        )
    return np.asarray(values / white)
