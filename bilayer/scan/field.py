"""The distance of a scan as a field on the shapes of a result."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.mechanics.dataset import SCAN_FIELD
from bilayer.results.milestones import along_milestones
from bilayer.results.released_shapes import MM_PER_M, released_shapes
from bilayer.results.schema import result_mesh
from bilayer.scan.cloud import Cloud
from bilayer.scan.comparison import ScanMatch
from bilayer.scan.samples import at_most

Array = NDArray[np.float64]

AROUND = 6
"""Points of the scan whose mean distance a node has."""


def distance_to_scan(result: xr.Dataset, scan: Cloud, matches: Sequence[ScanMatch]) -> xr.Dataset:
    """Return the distance of a scan at the nodes of the shapes that it was laid onto.

    Parameters
    ----------
    result : Dataset
        Whose shapes they are.
    scan : Cloud
        Of the part.
    matches : sequence of ScanMatch
        What `compare_scan` returned for both.

    Returns
    -------
    Dataset
        `distance_to_scan`, (prestretch, node), m: the mean of the nearest points of the scan that
        count, positive where they lie above the shape; not a number where the scan has a hole.
        It goes with the result as the other fields do, as in `bilayer.convert`.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> scan = bilayer.Cloud("above", result["position"].values[0] + [0, 0, 1e-4])
    >>> fields = bilayer.distance_to_scan(result, scan, bilayer.compare_scan(result, scan))
    >>> bool(abs(fields["distance_to_scan"]).max() < 3e-4)
    True
    """
    reached = along_milestones(result)
    found = np.full((reached.sizes["prestretch"], reached.sizes["node"]), np.nan)
    shapes = {shape.milestone: shape for shape in released_shapes(reached, result_mesh(reached))}
    for match in matches:
        points = shapes[match.milestone].surface.points
        nodes = np.asarray(points / MM_PER_M, dtype=np.float64)
        found[match.milestone] = _around(nodes, scan, match)
    about = {
        "units": "m",
        "long_name": "distance of the scan, positive above the shape",
        "mesh": "midsurface",
        "location": "node",
    }
    kept = ("prestretch", "prestretch_x", "prestretch_y")
    places = {name: reached[name] for name in kept if name in reached.variables}
    return xr.Dataset({SCAN_FIELD: (("prestretch", "node"), found, about)}, coords=places)


def _around(nodes: Array, scan: Cloud, match: ScanMatch) -> Array:
    """Return the mean distance of the points of the scan around each node, m."""
    from scipy.spatial import cKDTree  # slow to load

    points = match.motion.moved(at_most(len(match.distances), scan.points))[~match.outliers]
    tree = cKDTree(points)
    away, which = tree.query(nodes, AROUND, distance_upper_bound=match.reach)
    known = np.isfinite(away)
    distances = np.append(match.distances[~match.outliers], 0.0)[which]  # of none: the last one
    count = known.sum(axis=1)
    total = np.where(known, distances, 0.0).sum(axis=1)
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan))
