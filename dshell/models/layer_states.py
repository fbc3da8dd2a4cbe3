"""The deformation of the layers on bent faces, for the fields of a result.

The strain at a height is that of the energy (`dshell.energies.through_thickness`), and the stretch
of the thickness that of plane stress. Through the thickness the rotation is that of the face.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bilayer.mechanics.layer_state import LEVELS, LayerState, polar_rotation
from bilayer.mechanics.memory import ELASTIC, Memory
from dshell.energies.morley_faces import BentFaces
from dshell.energies.through_thickness import BentLayer
from dshell.materials.remembering import dead_stress

Array = NDArray[np.float64]


def layer_states(blocks: Sequence[BentFaces], turn: Array) -> list[LayerState]:
    """Return the deformation of each layer on all faces.

    Parameters
    ----------
    blocks : sequence of BentFaces
        The faces in order, some at a time.
    turn : (3, 3) array of float
        Rotation from the axes of the state to those in which the rotations are told.
    """
    starts = np.cumsum([0, *(len(block.areas) for block in blocks)])
    found: dict[str, list[LayerState]] = {}
    for first, block in zip(starts, blocks, strict=False):
        for bent in block.laminate.layers:
            state = _of_layer(block, bent, int(first), turn)
            found.setdefault(state.name, []).append(state)
    return [_joined(parts) for parts in found.values()]


def _of_layer(block: BentFaces, bent: BentLayer, first: int, turn: Array) -> LayerState:
    layer, here = bent.layer, bent.layer.face_numbers
    areas, tangents = block.areas[here], block.tangents[:, :, here]
    heights: Array = np.linspace(layer.bottom, layer.top, len(LEVELS), dtype=np.float64)
    memory = _memory_at(heights, bent)
    strain, material = bent.strain(heights), bent.at_heights(heights, memory)
    natural = np.moveaxis(np.broadcast_to(layer.prestretch, (2, 2, len(areas))), 2, 0)
    stretch = np.zeros((*strain.shape[1:], 3, 3))
    bonded = np.stack([1 + 2 * strain[0], strain[2], strain[2], 1 + 2 * strain[1]], axis=-1)
    stretch[..., :2, :2] = natural @ bonded.reshape(*strain.shape[1:], 2, 2) @ natural
    stretch[..., 2, 2] = material.thickness_stretch() ** 2
    rotation = turn @ _rotation(tangents, natural)
    return LayerState(
        layer.name,
        first + np.arange(len(block.areas))[here],
        stretch,
        np.broadcast_to(rotation, stretch.shape),
        None,
        areas * bent.law_energy(),
        areas * (layer.top - layer.bottom),
        ELASTIC
        if memory is None
        else Memory(memory.factor, dead_stress(layer.law, memory.pull, layer.prestretch)),
    )


def _memory_at(heights: Array, bent: BentLayer) -> Memory | None:
    """Return what a layer remembers at other heights than its Gauss points, by a polynomial."""
    layer = bent.layer
    if layer.memory is None:
        return None
    powers = np.arange(len(layer.heights))
    middle, half = (layer.bottom + layer.top) / 2, (layer.top - layer.bottom) / 2
    known, wanted = (((z - middle) / half)[:, None] ** powers for z in (layer.heights, heights))
    pull = np.einsum("lg,pgk->plk", wanted @ np.linalg.inv(known), layer.memory.pull)
    return Memory(layer.memory.factor, pull)


def _rotation(tangents: Array, natural: Array) -> Array:
    """Return the rotation of each face with its normal, from the natural axes, (m, 3, 3)."""
    along = np.moveaxis(tangents, 2, 0).transpose(0, 2, 1) @ natural
    normal = np.cross(along[..., 0], along[..., 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return polar_rotation(np.concatenate([along, normal[..., None]], axis=2))


def _joined(parts: Sequence[LayerState]) -> LayerState:
    def along(name: str, axis: int) -> Array:
        return np.concatenate([getattr(part, name) for part in parts], axis=axis)

    return LayerState(
        parts[0].name,
        np.concatenate([part.faces for part in parts]),
        along("stretch", 1),
        along("rotation", 1),
        None,
        along("energy", 0),
        along("volume", 0),
        _joined_memory(parts),
    )


def _joined_memory(parts: Sequence[LayerState]) -> Memory:
    memories = [part.memory for part in parts]
    if memories[0] is ELASTIC:
        return ELASTIC
    return Memory(memories[0].factor, np.concatenate([each.pull for each in memories], axis=1))
