"""A penalty on places of the skin that come near to each other: the sheet shall not touch itself.

It is the energy of the contact barrier (`bilayer.contact.barrier`) at a stiffness of 1 Pa, over the
sheet's area times the range: a share of the skin that is within range, so to say. It keeps its
weights while the mesh moves with the design, so it is a smooth function of the design.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bilayer.contact.barrier import Barrier, BarrierState
from bilayer.contact.skin import BondedBody
from bilayer.contact.skin_map import SkinMap
from bilayer.designing.equilibria import DesignShape, SheetMesh
from bilayer.designing.variables import value_of, with_values
from bilayer.errors import ComputationError
from bilayer.mesh.planar import flat_surface
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]

SMALL_CHANGE = 1e-5
"""Of a number of the design, relative."""


class GapPenalty:
    """The penalty of the designs on one moving mesh.

    Parameters
    ----------
    sheet : SheetMesh
        The moving mesh.
    range : float
        Distance from which on nothing counts, m; less if places of the flat sheet are nearer.
    """

    def __init__(self, sheet: SheetMesh, range: float) -> None:
        self._sheet = sheet
        flat = flat_surface(sheet.mesh)
        self._barrier = Barrier.of(
            self._skin(sheet.specimen), flat.points, range=range, stiffness=1.0
        )
        self._scale = flat.areas.sum() * self._barrier.range

    def of(self, shape: DesignShape, names: Sequence[str]) -> tuple[float, Array, Array]:
        """Return the penalty, its gradient by the position, (n, 3), and by numbers at rest, (k,).

        Raises
        ------
        ComputationError
            The sheet passes through itself.
        """
        return self.at(shape.specimen, shape.equilibrium.position, names)

    def at(
        self, specimen: Specimen, position: Array, names: Sequence[str]
    ) -> tuple[float, Array, Array]:
        """Return the same of a specimen whose reference surface is somewhere, m, (n, 3)."""
        skin = self._skin(specimen)
        points = skin.points(position)
        if self._barrier.is_crossed(points):
            raise ComputationError("the sheet passes through itself")
        near = self._barrier.at(points)
        if not near.pairs:
            return 0.0, np.zeros_like(position), np.zeros(len(names))
        by_position = skin.pull_back(position, near.gradient) / self._scale
        by_numbers = [self._by_number(specimen, name, position, near) for name in names]
        return near.energy / self._scale, by_position, np.array(by_numbers)

    def _by_number(
        self, specimen: Specimen, name: str, position: Array, near: BarrierState
    ) -> float:
        value = value_of(specimen, name)
        step = SMALL_CHANGE * abs(value)
        ahead, behind = (
            self._skin(with_values(specimen, {name: value + sign * step})).points(position)
            for sign in (1.0, -1.0)
        )
        return float(np.sum(near.gradient * (ahead - behind)) / (2 * step * self._scale))

    def _skin(self, specimen: Specimen) -> SkinMap:
        stretch = specimen.prestretch.milestones[-1]
        return SkinMap.of(BondedBody.of(specimen, self._sheet.of(specimen), stretch))
