"""The body's own frame, which a tilt carries along: z is the shape's axis, x the first strip.

z is the normal of the plane fitted to the rim, the outer boundary of the sheet, on the side of the
apex. x is where the planar x
axis, the first strip's centre line, has been carried by the rotation of the body as a whole.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bilayer.geometry.alignment import best_rotation
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import PlanarMesh, flat_surface

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

FLAT_SHAPE_TOLERANCE = 1e-6
"""Mean height over the rim, over the rim's rms radius, below which a shape has no apex."""


@dataclass(frozen=True, eq=False)
class BodyFrame:
    """An orthonormal right-handed frame.

    Parameters
    ----------
    origin : (3,) array of float
        Centroid of the rim nodes, m.
    axes : (3, 3) array of float
        The unit vectors x, y, z as rows.
    """

    origin: Array
    axes: Array

    def coordinates(self, points: Array) -> Array:
        """Return points given in space, (n, 3) in m, in this frame."""
        return (points - self.origin) @ self.axes.T

    def span(self, points: Array) -> Array:
        """Return the extent of points, (n, 3) in m, along x, y and z, m, shape (3,)."""
        return np.ptp(self.coordinates(points), axis=0)


def body_frame(mesh: PlanarMesh, position: Array) -> BodyFrame:
    """Return the body frame of a deformed planar mesh.

    Parameters
    ----------
    mesh : PlanarMesh
        The flat state.
    position : (n, 3) array of float
        Deformed nodes, m.
    """
    surface = Surface(position, mesh.triangles)
    rim = position[mesh.rim_nodes]
    origin = rim.mean(axis=0)
    normal = _plane_normal(rim - origin)
    normal = normal * _apex_side(normal, surface, origin, rim)
    carried = _whole_rotation(mesh, position)
    x = _rotate_x_axis(carried.apply([1.0, 0.0, 0.0]), carried.apply([0.0, 0.0, 1.0]), normal)
    return BodyFrame(origin, np.array([x, np.cross(normal, x), normal]))


def upright_frame(mesh: PlanarMesh, position: Array) -> BodyFrame:
    """Return the frame in which a shape is shown: that of the body, the upper side of the sheet up.

    A body that opens upwards has its apex below; `body_frame` turns it over, for its measures.

    Parameters
    ----------
    mesh, position
        As for `body_frame`.
    """
    frame = body_frame(mesh, position)
    upper = _whole_rotation(mesh, position).apply([0.0, 0.0, 1.0])
    if upper @ frame.axes[2] >= 0:
        return frame
    x, y, z = frame.axes
    return BodyFrame(frame.origin, np.array([x, -y, -z]))


def _plane_normal(centred: Array) -> Array:
    """Return the normal of the least-squares plane: the direction of least variance."""
    return np.linalg.eigh(centred.T @ centred)[1][:, 0]


def _apex_side(normal: Array, surface: Surface, origin: Array, rim: Array) -> float:
    """+1 if the normal points to the side of the rim's plane on which the body lies, else -1.

    A flat body lies on neither; there its own upper side is taken.
    """
    height = normal @ (surface.centroid - origin)
    radius = np.sqrt(np.mean(np.sum((rim - origin) ** 2, axis=1)))
    if abs(height) > FLAT_SHAPE_TOLERANCE * radius:
        return float(np.sign(height))
    return 1.0 if normal @ surface.area_vectors.sum(axis=0) >= 0 else -1.0


def _whole_rotation(mesh: PlanarMesh, position: Array) -> "Rotation":
    """Rotation that brings the flat state nearest to the deformed one, by flat areas."""
    flat = flat_surface(mesh)
    return best_rotation(flat.points, position, flat.node_areas)


def _rotate_x_axis(x: Array, z: Array, normal: Array) -> Array:
    """Rotate x, perpendicular to z, by the smallest rotation that takes the line of z to `normal`.

    For unit vectors it is x - (n.x)/(1 + n.z) (n + z), Rodrigues' formula with x.z = 0. z is
    turned to the side of the normal first, so that the formula never comes near its pole.
    """
    z = z if normal @ z >= 0 else -z
    return x - (normal @ x) / (1 + normal @ z) * (normal + z)
