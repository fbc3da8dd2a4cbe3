"""The states that are known: which finds are one state, and how often each was found."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bilayer.landscape.symmetry import Images
from bilayer.results.schema import MilestoneState
from bilayer.specimen.outline import Symmetry

Array = NDArray[np.float64]

SAME_SHAPE = 0.01
"""Rms distance over the characteristic length within which two finds may be one state.

Images of a state on a mesh without its symmetry are 1e-4 apart, states of it 0.04 and more."""
SAME_ENERGY = 1e-3
"""Relative difference of their energies."""
LOWER = 1e-7
"""Relative difference of the energies of two images from which on the lower one is kept."""
NOWHERE = -1
"""The state of a start that led to none."""


@dataclass(frozen=True, eq=False)
class State:
    """A stable shape.

    Parameters
    ----------
    milestone : MilestoneState
        Its shape, energy and measures.
    stiffness : (2,) array of float
        Least eigenvalues of its stiffness over the flat area, N/m3.
    symmetry : Symmetry
        The part of the specimen's symmetry that it has.
    times_found : int
        Finds of it.
    """

    milestone: MilestoneState
    stiffness: Array
    symmetry: Symmetry
    times_found: int = 1

    @property
    def energy(self) -> float:
        """Energy, J."""
        return sum(self.milestone.energy.values())

    @property
    def position(self) -> Array:
        """The reference surface, m, shape (n, 3)."""
        return self.milestone.position


class Catalogue:
    """The states that are known, in the order in which they were found.

    Parameters
    ----------
    images : Images
        Under the symmetry of the specimen.
    length : float
        Its characteristic length, m.
    states : sequence of State
        Known from the beginning.
    """

    def __init__(self, images: Images, length: float, states: list[State] | None = None) -> None:
        self.images, self._length = images, length
        self.states = states or []
        self.visits: list[tuple[str, tuple[int, ...]]] = []
        """Each start by its name, and the states that it led to."""

    @property
    def tolerance(self) -> float:
        """Distance within which two shapes may be one, m."""
        return SAME_SHAPE * self._length

    def place_of(self, position: Array, energy: float) -> int | None:
        """Return the place of the state that a find is, None if it is a new one."""
        for place, state in enumerate(self.states):
            apart = abs(energy - state.energy)
            near = apart <= SAME_ENERGY * max(abs(energy), abs(state.energy))
            if near and self.images.distance(position, state.position) <= self.tolerance:
                return place
        return None

    def add(self, state: State) -> int:
        """Add a new state; return its place."""
        self.states.append(state)
        return len(self.states) - 1

    def count_again(self, place: int) -> None:
        """Count one more find of a state."""
        state = self.states[place]
        self.states[place] = replace(state, times_found=state.times_found + 1)

    def is_lower(self, place: int, energy: float) -> bool:
        """Whether an image of a state, on a mesh without its symmetry, is lower than that kept."""
        known = self.states[place].energy
        return energy < known - LOWER * abs(known)

    def keep_image(self, place: int, image: State) -> None:
        """Keep another image of a state; the finds are those of the state."""
        found = self.states[place].times_found
        self.states[place] = replace(image, times_found=found)

    def symmetry_of(self, position: Array) -> Symmetry:
        """Return the part of the specimen's symmetry that a shape has."""
        return self.images.symmetry_of(position, self.tolerance)

    def order(self) -> list[int]:
        """Return the places of the states, the lowest energy first."""
        return sorted(range(len(self.states)), key=lambda place: self.states[place].energy)

    def shapes_to_avoid(self) -> Iterator[Array]:
        """Yield the images of all states that differ."""
        for state in self.states:
            kept: list[Array] = []
            for image in self.images.of(state.position):
                if all(self.images.plain_distance(image, k) > self.tolerance for k in kept):
                    kept.append(image)
            yield from kept


def chance_of_another(times_found: Array, starts: int) -> float:
    """Return the estimated chance that one more start finds a state that is not known.

    That is the share of the finds whose state was found once (Good, Biometrika 40, 1953, equation
    9, after Turing). It holds for starts drawn at random; those here are more diverse.

    Examples
    --------
    >>> chance_of_another(np.array([12, 6, 1, 1]), 20)
    0.1
    """
    return float(np.count_nonzero(times_found == 1) / starts) if starts else 1.0
