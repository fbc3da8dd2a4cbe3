"""Caveats of a shape: unstable, passing through itself, of a thick shell, on a coarse mesh."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.geometry.surface import Surface
from bilayer.geometry.turns import turns_over_edges
from bilayer.results.schema import CONTACT_CROSSES
from bilayer.specimen.specimen import Specimen

THICKEST_SHELL = 0.1
"""Whole thickness over the characteristic length up to which a shell stands for the solid.

At a prestretch of 1.06 the solvers are within 0.5 % of that length of each other up to a share of
0.2 (docs/any_sheet.md). At 1.2 they are about 1 % apart; but a thick sheet that is symmetric to its
middle bends later by the shell than as a solid: a trilayer lotus of 0.15 is still flat by the shell
at 1.2 where the solid has bent, 4 % away, and one of 0.1 has 0.86 of its height at 1.12.
"""

SHARPEST_TURN = np.radians(20)
"""Rms angle between neighbouring triangles up to which a shell's mesh is fine enough, rad.

An edge between triangles of size h turns by h k / sqrt(3) where the curvature is k: 20 degrees are
0.6 mesh sizes to a radius of curvature. Beyond, the best sphere of the template is 2 to 8 % off
(docs/shell-measurements.md, "Mesh and curvature").
"""


def is_unstable(result: xr.Dataset) -> NDArray[np.bool_]:
    """Return for each milestone whether its shape is unstable: a shape nearby has less energy.

    False if the method cannot tell.
    """
    return np.asarray(result["unstable_modes"].values > 0)


def touches_itself(result: xr.Dataset) -> NDArray[np.bool_]:
    """Return for each milestone whether the body touches itself and nothing resists it.

    False if it is not known, as in files older than the measure. If contact was modelled, a body
    that touches itself is as it should be; one that passes through itself all the same is not.
    """
    touches = np.zeros(result["converged"].shape, dtype=bool)
    if "self_contact_gap" in result:
        touches = result["self_contact_gap"].values == 0
    if CONTACT_CROSSES in result:
        crosses = result[CONTACT_CROSSES].values
        touches = np.where(np.isnan(crosses), touches, crosses == 1)
    return np.asarray(touches)


def caveats(result: xr.Dataset) -> list[str]:
    """Return a few words for each milestone of one result, empty if nothing is against it."""
    words = zip(
        np.where(is_unstable(result), "unstable", ""),
        np.where(touches_itself(result), "touches itself", ""),
        strict=True,
    )
    return [", ".join(filter(None, pair)) for pair in words]


def thickness_share(specimen: Specimen) -> float:
    """Return the natural thickness of all layers together over the characteristic length."""
    return sum(layer.thickness for layer in specimen.layers) / specimen.characteristic_length


def is_thick(specimen: Specimen) -> bool:
    """Whether a sheet is so thick that a shell does not stand for it, see `THICKEST_SHELL`."""
    return thickness_share(specimen) > THICKEST_SHELL * (1 + 1e-9)


def rms_turns(result: xr.Dataset) -> NDArray[np.float64]:
    """Return the rms angle between neighbouring triangles at each milestone, rad; NaN: no shape.

    It is the mesh size over the radius of curvature, see `SHARPEST_TURN`.
    """
    triangles = result["face_nodes"].values.astype(np.int64)
    turns = [turns_over_edges(Surface(shape, triangles)) for shape in result["position"].values]
    return np.array([np.sqrt(np.mean(turn**2)) for turn in turns])


def is_coarse(result: xr.Dataset) -> NDArray[np.bool_]:
    """Return for each milestone whether the mesh of a shell is too coarse for its curvature.

    False for the finite-element model, whose elements are curved.
    """
    if result.attrs["solver"] != "dshell":
        return np.zeros(result["converged"].shape, dtype=bool)
    return np.asarray(rms_turns(result) > SHARPEST_TURN)
