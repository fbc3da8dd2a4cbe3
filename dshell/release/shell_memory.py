"""What the layers of a shell remember on its way through time."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mechanics.memory import History, Memory
from dshell.energies.morley_faces import MorleyFaces
from dshell.materials.remembering import nothing

Array = NDArray[np.float64]
Histories = list[dict[str, History]]
"""For each block of faces, that of each layer that relaxes, by its name."""


class ShellMemory:
    """The histories of all layers that relax, and the step of time that is being taken.

    Parameters
    ----------
    hold : float
        Time for which the stretched layers were held before they were bonded, s.

    Attributes
    ----------
    time : float
        Of the last equilibrium, s after the release.
    """

    def __init__(self, hold: float) -> None:
        self.time = 0.0
        self._hold, self._step = hold, 0.0
        self._histories: Histories | None = None

    def aim_at(self, time: float) -> None:
        """Take a step from the last equilibrium to a time."""
        self._step = time - self.time

    def remembering(self, blocks: Sequence[MorleyFaces], flat: Array) -> list[MorleyFaces]:
        """Return faces with their layers' memory of this step.

        Parameters
        ----------
        blocks : sequence of MorleyFaces
            All faces at a prestretch, some at a time, without memory.
        flat : (dofs,) array of float
            The flat bonded state, which is where they were held.
        """
        known = self._histories or self._held(blocks, flat)
        return [
            block.with_laminate(
                replace(
                    block.laminate,
                    layers=[
                        replace(layer, memory=own[layer.name].memory(self._step))
                        if layer.name in own
                        else layer
                        for layer in block.laminate.layers
                    ],
                )
            )
            for block, own in zip(blocks, known, strict=True)
        ]

    def arrive(self, blocks: Sequence[MorleyFaces], flat: Array, state: Array) -> None:
        """Keep what the layers remember in the equilibrium at the end of the step."""
        known = self._histories or self._held(blocks, flat)
        memories = [
            {name: history.memory(self._step) for name, history in own.items()} for own in known
        ]
        self._histories = [
            {name: history.after(self._step, now[name]) for name, history in own.items()}
            for own, now in zip(known, _stresses(blocks, state, memories), strict=True)
        ]
        self.time += self._step
        self._step = 0.0

    def _held(self, blocks: Sequence[MorleyFaces], flat: Array) -> Histories:
        return [
            {
                layer.name: History.held(layer.relaxation, stresses[layer.name], self._hold)
                for layer in block.laminate.layers
                if layer.relaxation.terms
            }
            for block, stresses in zip(
                blocks, _stresses(blocks, flat, [{}] * len(blocks)), strict=True
            )
        ]

    def save(self) -> dict[str, Array]:
        """Return it as arrays by name."""
        saved = {"time": np.array(self.time)}
        for number, own in enumerate(self._histories or []):
            for name, history in own.items():
                saved[f"stress.{number}.{name}"] = history.stress
                saved[f"inner.{number}.{name}"] = history.inner
        return saved

    def restore(
        self, saved: Mapping[str, Array], blocks: Sequence[MorleyFaces], flat: Array
    ) -> None:
        """Be as it was saved, for the same faces; InputError if it is not what they remember."""
        try:
            histories = [
                {
                    layer.name: History(
                        layer.relaxation,
                        np.asarray(saved[f"stress.{number}.{layer.name}"], dtype=np.float64),
                        np.asarray(saved[f"inner.{number}.{layer.name}"], dtype=np.float64),
                    )
                    for layer in block.laminate.layers
                    if layer.relaxation.terms
                }
                for number, block in enumerate(blocks)
            ]
            self.time, self._step = float(saved["time"]), 0.0
        except KeyError as error:
            raise InputError(
                f"resume: {error} is missing, expected what layers remember"
            ) from error
        for own, held in zip(histories, self._held(blocks, flat), strict=True):
            for name, history in own.items():
                found, expected = history.inner.shape, held[name].inner.shape
                if found != expected or history.stress.shape != expected[1:]:
                    raise InputError(
                        f"resume: the memory of {name} has the shape {found}, expected {expected}; "
                        "a run of an earlier version cannot be resumed in time"
                    )
        self._histories = histories


def _stresses(
    blocks: Sequence[MorleyFaces], state: Array, memories: Sequence[Mapping[str, Memory]]
) -> list[dict[str, Array]]:
    """Return the instantaneous stresses of the layers that relax, by block and name.

    Each has the memory of the step that leads to the state, or none.
    """
    return [
        {
            bent.layer.name: bent.instantaneous(own.get(bent.layer.name, nothing(bent.layer.law)))
            for bent in block.at(state).laminate.layers
            if bent.layer.relaxation.terms
        }
        for block, own in zip(blocks, memories, strict=True)
    ]
