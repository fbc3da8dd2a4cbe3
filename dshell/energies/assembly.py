"""From elements to the whole: energies, forces and one sparse Hessian of fixed pattern.

The state is a vector of degrees of freedom: the nodes' coordinates, node by node, and whatever
else a model adds behind them. An energy is a sum over elements. Its second derivative is a sum of
small matrices, each of which couples a few degrees of freedom, its stencil. All are symmetric, so
the lower halves tell all. Where each entry goes in the sparse matrix is found once; an assembly is
then one `bincount` over all entries.
"""

from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix, tril

Array = NDArray[np.float64]


class Deformed(Protocol):
    """The elements of an energy in one state; what one derivative needs serves the next."""

    def energy(self) -> Array:
        """Return each element's energy, J, shape (n,)."""

    def gradient(self) -> Array:
        """Return the derivative of the sum by the whole state, N, shape (dofs,)."""

    def hessian(self) -> Sequence[Array]:
        """Return its second derivative, N/m, shape (n, k, k) for each of the energy's stencils."""

    def convex_hessian(self) -> Sequence[Array]:
        """Return a convex replacement of the Hessian: its sum has no negative eigenvalue."""


class Energy(Protocol):
    """A sum of element energies."""

    @property
    def name(self) -> str:
        """Name of the energy in a result."""

    @property
    def stencils(self) -> Sequence[NDArray[np.int64]]:
        """Degrees of freedom that the parts of its Hessian couple, arrays of shape (n, k).

        A row may name one twice: around a node of three triangles, two neighbours have one apex.
        """

    def at(self, state: Array) -> Deformed:
        """Return the elements in a state: all degrees of freedom, m, shape (dofs,)."""


class Assembly:
    """The places of some energies' Hessians in the matrix of the free dofs.

    Parameters
    ----------
    size : int
        Number of degrees of freedom.
    energies : sequence of Energy
        Of the elements, in whatever rest state: their stencils are what counts.
    held : array of int
        Degrees of freedom that do not change.
    """

    def __init__(
        self,
        size: int,
        energies: Sequence[Energy],
        held: Sequence[int] | NDArray[np.int64] = (),
    ) -> None:
        self.size = size
        self.free = np.setdiff1d(np.arange(size), held)
        count = len(self.free)
        number = np.full(size, count, dtype=np.intc)  # of the held dofs: past the last
        number[self.free] = np.arange(count)
        diagonal = np.arange(count, dtype=np.intc)
        halves = [_lower_places(number[dofs]) for term in energies for dofs in term.stencils]
        twice, rows, columns = (np.concatenate(parts) for parts in zip(*halves, strict=True))
        self._twice = np.flatnonzero(twice)
        rows, columns = np.concatenate([diagonal, rows]), np.concatenate([diagonal, columns])
        slots, rows, columns = _distinct(rows, columns, count + 1)
        self._slot_count = len(rows)
        self._diagonal_slots, self._slots = slots[:count], slots[count:]
        stored = rows < count  # the entries of held dofs have a slot, but no place in the matrix
        place = rows[stored], columns[stored]
        numbers = csc_matrix((np.flatnonzero(stored) + 1, place), shape=(count, count))
        whole = (numbers + tril(numbers, -1).T).tocsc()
        whole.sort_indices()
        self._slot_of_stored = whole.data - 1
        # SciPy would make 64-bit places shorter for every matrix
        self._rows = whole.indices.astype(np.intc)
        self._column_starts = whole.indptr.astype(np.intc)

    def hessian(self, deformed: Sequence[Deformed], diagonal: Array | float = 0.0) -> csc_matrix:
        """Return the second derivative by the free dofs, N/m, plus a diagonal.

        Parameters
        ----------
        deformed : sequence of Deformed
            The energies that the assembly was made for, in their order, in one state.
        diagonal : (free dofs,) array of float or float
            Added to the diagonal, N/m.
        """
        return self._matrix((part for term in deformed for part in term.hessian()), diagonal)

    def convex_hessian(self, deformed: Sequence[Deformed]) -> csc_matrix:
        """Return a convex replacement of `hessian`, without negative eigenvalues."""
        return self._matrix((part for term in deformed for part in term.convex_hessian()), 0.0)

    def of_free_dofs(self, matrix: csr_matrix) -> csc_matrix:
        """Return the part of a matrix by the first dofs, (k, k), that belongs to the free ones."""
        entries, count = matrix.tocoo(), len(self.free)
        number = np.full(self.size, count, dtype=np.intc)
        number[self.free] = np.arange(count)
        rows, columns = number[entries.row], number[entries.col]
        kept = (rows < count) & (columns < count)
        places = rows[kept], columns[kept]
        return csc_matrix((entries.data[kept], places), shape=(count, count))

    def _matrix(self, parts: Iterable[Array], diagonal: Array | float) -> csc_matrix:
        values = np.empty(len(self._slots))
        begin = 0
        for part in parts:
            begin = _copy_lower_half(part, values, begin)
        values[self._twice] *= 2
        total = sum_at(self._slots, values, self._slot_count)
        total[self._diagonal_slots] += diagonal
        size = len(self._column_starts) - 1
        data = total[self._slot_of_stored]
        return csc_matrix((data, self._rows, self._column_starts), shape=(size, size))


def deform(energies: Sequence[Energy], state: Array) -> list[Deformed]:
    """Return each energy's elements in a state, the values of all dofs in m, in any shape."""
    return [term.at(state.reshape(-1)) for term in energies]


def gradient_of(deformed: Sequence[Deformed]) -> Array:
    """Return the derivative of some energies in one state by all dofs, N, shape (dofs,)."""
    total = deformed[0].gradient()
    for part in deformed[1:]:
        total += part.gradient()
    return total


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


def sum_at(dofs: NDArray[np.int64], values: Array, size: int) -> Array:
    """Return, for each of `size` degrees of freedom, the sum of the values that belong to it."""
    total = np.bincount(dofs.reshape(-1), values.reshape(-1), minlength=size)
    return total.astype(np.float64, copy=False)


def _lower_places(
    dofs: NDArray[np.intc],
) -> tuple[NDArray[np.bool_], NDArray[np.intc], NDArray[np.intc]]:
    """Return a mask of the lower half's entries that count twice, and their rows and columns.

    Between two places of one dof the lower half has one entry of two, both of which go on the
    diagonal.
    """
    row, column = np.tril_indices(dofs.shape[1])
    one, other = dofs[:, row].reshape(-1), dofs[:, column].reshape(-1)
    twice = (one == other) & np.tile(row != column, len(dofs))
    return twice, np.maximum(one, other), np.minimum(one, other)


def _distinct(
    rows: NDArray[np.intc], columns: NDArray[np.intc], size: int
) -> tuple[NDArray[np.int64], NDArray[np.intc], NDArray[np.intc]]:
    """Return each place's number among the distinct ones, and these, by columns, then rows."""
    order = _counting_order(rows, size)
    order = order[_counting_order(columns[order], size)]
    rows, columns = rows[order], columns[order]
    new = np.ones(len(order), dtype=bool)
    new[1:] = (rows[1:] != rows[:-1]) | (columns[1:] != columns[:-1])
    numbers = np.empty(len(order), dtype=np.int64)
    numbers[order] = np.cumsum(new) - 1
    return numbers, rows[new], columns[new]


def _counting_order(keys: NDArray[np.intc], size: int) -> NDArray[np.intc]:
    """Return the order that sorts numbers below `size`, like ones as they come.

    SciPy gathers a matrix's entries by rows in linear time: here one entry for each key.
    """
    places = np.arange(len(keys), dtype=np.intc)
    return csr_matrix((places, (keys, places)), shape=(size, len(keys))).data


def _copy_lower_half(matrices: Array, values: Array, begin: int) -> int:
    """Copy the entries on and below the diagonal of symmetric matrices (n, k, k), row by row.

    They go into `values` from the place `begin`, matrix after matrix; returns the place after them.
    A row is copied as a whole, because an index by entries costs twice the time on fine meshes.
    """
    count, size = matrices.shape[:2]
    width = size * (size + 1) // 2
    end = begin + count * width
    halves = values[begin:end].reshape(count, width)
    for row in range(size):
        first = row * (row + 1) // 2
        halves[:, first : first + row + 1] = matrices[:, row, : row + 1]
    return end
