"""The layers of a sheet in a result: which of them lie on each face, and what they are called."""

from typing import Any

import numpy as np

from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.two_layers import LAYERS, TWO_LAYERS

BODIES = {2: "bilayer", 3: "trilayer"}


def body_name(specimen: Specimen) -> str:
    """Return the name of a sheet by its number of layers."""
    return BODIES.get(len(specimen.layers), f"sheet of {len(specimen.layers)} layers")


def surface_name(specimen: Specimen) -> str:
    """Return the name of the reference surface: "bonded interface", "middle of substrate"."""
    two = len(specimen.layers) == len(LAYERS)
    return "bonded interface" if two else str(specimen.reference_surface)


def layer_variables(specimen: Specimen, mesh: PlanarMesh) -> dict[str, Any]:
    """Return the variables that say which layers lie on each face.

    `region` numbers the sets of layers as `Specimen.layer_sets` does; `layers_present` has a column
    for each layer, from the bottom up.
    """
    names = specimen.layer_names
    present = np.zeros((len(mesh.triangles), len(names)), dtype=np.int8)
    for column, name in enumerate(names):
        present[mesh.faces_of(name), column] = 1
    on_faces = {"mesh": "midsurface", "location": "face"}
    return {
        "region": (
            "face",
            mesh.region.astype(np.int32),
            {
                "long_name": "layers of the face",
                "flag_values": np.arange(len(mesh.layer_sets), dtype=np.int32),
                "flag_meanings": " ".join(_set_names(specimen, mesh)),
                **on_faces,
            },
        ),
        "layers_present": (
            ("face", "sheet_layer"),
            present,
            {"long_name": "whether a layer lies on the face", **on_faces},
        ),
        "sheet_layer": (
            "sheet_layer",
            np.array(names, dtype=object),
            {"long_name": "layers from the bottom up"},
        ),
    }


def _set_names(specimen: Specimen, mesh: PlanarMesh) -> list[str]:
    """Return a word for each set of layers, from the bottom up: "lower+substrate"."""
    if mesh.layer_sets == TWO_LAYERS:
        return ["bare", "kirigami"]
    return [
        "+".join(name for name in specimen.layer_names if name in names) or "nothing"
        for names in mesh.layer_sets
    ]
