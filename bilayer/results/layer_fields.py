"""Which layers lie on each face of a result, as variables of the dataset, and back."""

from typing import Any

import numpy as np
import xarray as xr

from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.two_layers import TWO_LAYERS

TWO_LAYER_WORDS = "bare kirigami"
"""What the regions of a bilayer are called, see `TWO_LAYERS`."""
NO_LAYER = "."
"""What a region without any layer is called, which no face has."""


def layer_variables(specimen: Specimen, mesh: PlanarMesh) -> dict[str, Any]:
    """Return `region`, whose flags name the layers of each, and `layers_present` by face and layer.

    Parameters
    ----------
    specimen : Specimen
        Its layers, from the bottom up.
    mesh : PlanarMesh
        Which of them lie on each face.
    """
    names = specimen.layer_names
    present = np.zeros((len(mesh.triangles), len(names)), dtype=np.int32)
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
                "flag_meanings": _words_of(mesh.layer_sets, names),
            }
            | on_faces,
        ),
        "layers_present": (
            ("face", "layer_name"),
            present,
            {"long_name": "whether a layer lies on the face, 1 if so"} | on_faces,
        ),
        "layer_name": (
            "layer_name",
            np.array(names, dtype=object),
            {"long_name": "layers, from the bottom up"},
        ),
    }


def layer_sets_of(result: xr.Dataset) -> tuple[frozenset[str], ...]:
    """Return the sets of layers that the regions of a result stand for."""
    words = result["region"].attrs.get("flag_meanings", TWO_LAYER_WORDS)
    if words == TWO_LAYER_WORDS:
        return TWO_LAYERS
    return tuple(frozenset(word.split("+")) - {NO_LAYER} for word in words.split())


def _words_of(layer_sets: tuple[frozenset[str], ...], names: tuple[str, ...]) -> str:
    if layer_sets == TWO_LAYERS:
        return TWO_LAYER_WORDS
    ordered = ([name for name in names if name in there] for there in layer_sets)
    return " ".join("+".join(there) if there else NO_LAYER for there in ordered)
