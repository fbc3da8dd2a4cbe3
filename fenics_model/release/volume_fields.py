"""The volume mesh and its positions as variables of the dataset, a second UGRID mesh."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.specimen.two_layers import LAYERS
from fenics_model.mesh.volume_mesh import VolumeMesh


def volume_dataset(
    volume: VolumeMesh,
    layer_names: Sequence[str],
    positions: Sequence[NDArray[np.float64] | None],
    milestones: int,
) -> xr.Dataset:
    """Build the volume variables of a result.

    Parameters
    ----------
    volume : VolumeMesh
        The undeformed mesh (of the natural thickness, or the bonded one).
    layer_names : sequence of str
        Of its layers, from the bottom up.
    positions : sequence of (v, 3) array of float or None
        Deformed vertices at the milestones in order, m; None if it was not reached.
    milestones : int
        Number of milestones; those not reached become NaN.
    """
    known = LAYERS if set(layer_names) <= set(LAYERS) else tuple(layer_names)
    number = np.array([known.index(name) for name in layer_names])
    reached = np.full((milestones, *volume.points.shape), np.nan)
    for row, position in zip(reached, positions, strict=False):
        if position is not None:
            row[:] = position
    on_nodes = {"units": "m", "mesh": "volume", "location": "node"}
    on_cells = {"mesh": "volume", "location": "volume"}
    return xr.Dataset(
        {
            "volume": (
                (),
                np.int32(0),
                {
                    "cf_role": "mesh_topology",
                    "topology_dimension": np.int32(3),
                    "node_coordinates": "volume_reference_x volume_reference_y volume_reference_z",
                    "volume_node_connectivity": "volume_cells",
                    "long_name": "the layers as a mesh of tetrahedra",
                },
            ),
            **{
                f"volume_reference_{axis}": (
                    "volume_node",
                    column,
                    {"units": "m", "long_name": f"{axis} in the undeformed volume mesh"},
                )
                for axis, column in zip("xyz", volume.points.T, strict=True)
            },
            "volume_reference_position": (
                ("volume_node", "xyz"),
                volume.points,
                on_nodes | {"long_name": "undeformed volume mesh"},
            ),
            "volume_position": (
                ("prestretch", "volume_node", "xyz"),
                reached,
                on_nodes | {"long_name": "released volume mesh"},
            ),
            "volume_cells": (
                ("volume_cell", "vertex"),
                volume.cells.astype(np.int32),
                {"cf_role": "volume_node_connectivity", "start_index": np.int32(0)},
            ),
            "layer": (
                "volume_cell",
                number[volume.layer].astype(np.int32),
                on_cells
                | {
                    "long_name": "layer of the cell",
                    "flag_values": np.arange(len(known), dtype=np.int32),
                    "flag_meanings": " ".join(known),
                },
            ),
        }
    )
