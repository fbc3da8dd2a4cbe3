"""From elements to the whole: energies, forces and one sparse Hessian of fixed pattern.

The state is a vector of degrees of freedom: the nodes' coordinates, node by node, and whatever
else a model adds behind them. An energy is a set of like elements, each of a few of these. Where
each entry of each element's Hessian goes in the sparse matrix is found once; an assembly is then
one `bincount` over all entries.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

Array = NDArray[np.float64]


class Deformed(Protocol):
    """The elements of an energy in one state; what one derivative needs serves the next."""

    def energy(self) -> Array:
        """Return each element's energy, J, shape (n,)."""

    def gradient(self) -> Array:
        """Return its derivative by the element's degrees of freedom, N, shape (n, ...)."""

    def hessian(self) -> Array:
        """Return its second derivative, N/m, shape (n, k, k)."""

    def convex_hessian(self) -> Array:
        """Return a matrix near to it without negative eigenvalues, N/m, shape (n, k, k)."""


class Energy(Protocol):
    """A sum of like element energies, each of the values of its own degrees of freedom."""

    @property
    def name(self) -> str:
        """What the energy is called in a result."""

    @property
    def dofs(self) -> NDArray[np.int64]:
        """Degrees of freedom of each element, k of them, shape (n, ...)."""

    def at(self, values: Array) -> Deformed:
        """Return the elements in a state; the values have the shape of `dofs`, in m."""


class Assembly:
    """Where the elements of some energies go in the vectors and the matrix of the free dofs.

    Parameters
    ----------
    size : int
        Number of degrees of freedom.
    stencils : sequence of (n, ...) arrays of int
        The degrees of freedom of the elements, one array per energy.
    held : array of int
        Degrees of freedom that do not change.
    """

    def __init__(
        self,
        size: int,
        stencils: Sequence[NDArray[np.int64]],
        held: Sequence[int] | NDArray[np.int64] = (),
    ) -> None:
        self.size = size
        self.free = np.setdiff1d(np.arange(size), held)
        stencil_dofs = [dofs.reshape(len(dofs), -1) for dofs in stencils]
        self._dofs = np.concatenate([dofs.reshape(-1) for dofs in stencil_dofs])
        count = len(self.free)
        number = np.full(size, -1)
        number[self.free] = np.arange(count)
        entries = [_entries(number[dofs], count) for dofs in stencil_dofs]
        diagonal = np.arange(count) * (count + 1)
        # the entries of held dofs are numbered past the last: they end in a slot of their own
        pattern, slots = np.unique(np.concatenate([diagonal, *entries]), return_inverse=True)
        stored = int(np.searchsorted(pattern, count * count))
        self._diagonal_slots = slots[:count]
        self._slots = slots[count:]
        columns, rows = np.divmod(pattern[:stored], max(count, 1))
        starts = np.searchsorted(columns, np.arange(count + 1))
        # SciPy would make 64-bit places shorter for every matrix
        self._rows, self._column_starts = rows.astype(np.intc), starts.astype(np.intc)

    def gradient(self, deformed: Sequence[Deformed]) -> Array:
        """Return the derivative of the energies by the whole state, N, shape (dofs,).

        Parameters
        ----------
        deformed : sequence of Deformed
            The energies that the assembly was made for, in their order, in one state.
        """
        parts = [part.gradient().reshape(-1) for part in deformed]
        total = np.bincount(self._dofs, np.concatenate(parts), minlength=self.size)
        return total.astype(np.float64, copy=False)

    def hessian(self, deformed: Sequence[Deformed], diagonal: Array | float = 0.0) -> csc_matrix:
        """Return the second derivative by the free dofs, N/m, plus a diagonal.

        Parameters
        ----------
        deformed : sequence of Deformed
            As for `gradient`.
        diagonal : (free dofs,) array of float or float
            Added to the diagonal, N/m.
        """
        return self._matrix([part.hessian() for part in deformed], diagonal)

    def convex_hessian(self, deformed: Sequence[Deformed]) -> csc_matrix:
        """Return the like of `hessian` that has no negative eigenvalue."""
        return self._matrix([part.convex_hessian() for part in deformed], 0.0)

    def _matrix(self, parts: list[Array], diagonal: Array | float) -> csc_matrix:
        stored = len(self._rows)
        values = np.concatenate([part.reshape(-1) for part in parts])
        total = np.bincount(self._slots, values, minlength=stored + 1)
        data = total[:stored].astype(np.float64, copy=False)
        data[self._diagonal_slots] += diagonal
        size = len(self._column_starts) - 1
        return csc_matrix((data, self._rows, self._column_starts), shape=(size, size))


def deform(energies: Sequence[Energy], state: Array) -> list[Deformed]:
    """Return each energy's elements in a state, the values of all dofs in m, in any shape."""
    flat = state.reshape(-1)
    return [term.at(flat[term.dofs]) for term in energies]


def energy_sums(deformed: Sequence[Deformed]) -> list[float]:
    """Return the sum over the elements of each energy, J."""
    return [float(part.energy().sum()) for part in deformed]


def total_energies(energies: Sequence[Energy], state: Array) -> dict[str, float]:
    """Return the total of each energy by its name, J."""
    sums = energy_sums(deform(energies, state))
    return {term.name: total for term, total in zip(energies, sums, strict=True)}


def coordinates_of(nodes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the places of nodes' coordinates in the state: (n, k) nodes give (n, k, 3)."""
    return 3 * nodes[..., None] + np.arange(3)


def _entries(dofs: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """Return the number of each entry, column by column; size * size for those of held dofs."""
    rows, columns = dofs[:, :, None], dofs[:, None, :]
    return np.where((rows < 0) | (columns < 0), size * size, columns * size + rows).reshape(-1)
