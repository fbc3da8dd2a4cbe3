"""Hinges and springs with laminate theory's natural angles and lengths: the paper's method mended.

The surface bends about the neutral axis of whatever is there; the step between that of the bare
substrate and that of the bilayer is left out, and the surface counts as the bond (0.3 mm from it in
the paper's bilayer). What no choice of lengths and angles can mend, the lattice's
own Poisson's ratios, stands in docs/theory-dshell.md.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mechanics.layer_state import LayerState
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen, refuse_fields
from dshell.energies.assembly import Energy, total_energies
from dshell.energies.topology import Topology
from dshell.models.hinge_rest_state import laminate_springs_and_hinges, specimen_sections

Array = NDArray[np.float64]


class HingeModel:
    """A specimen on its planar mesh as a lattice; see `dshell.release.static.ShellModel`.

    Parameters
    ----------
    specimen, mesh
        What is released, on which planar mesh.

    Raises
    ------
    InputError
        A support keeps the slope of the sheet.
    """

    extra_dofs = 0
    extra_flat: Array = np.empty(0)
    fixed_dofs: NDArray[np.int64] = np.empty(0, dtype=np.int64)

    def __init__(self, specimen: Specimen, mesh: PlanarMesh) -> None:
        refuse_fields(specimen, "the model hinge")
        for support in specimen.supports:
            if support.keeps_slope:
                raise InputError(
                    f"supports.{support.name}.kind = {support.kind!r}: the model hinge keeps no "
                    "slope, expected 'hinged', or the model morley"
                )
        self._specimen, self._mesh = specimen, mesh
        self.fold_count = len(Topology.of(mesh.triangles).hinges)

    def energies(self, stretch: tuple[float, float]) -> Sequence[Energy]:
        """Return springs and hinges, the prestretch being (lambda_x, lambda_y)."""
        return laminate_springs_and_hinges(self._mesh, *specimen_sections(self._specimen, stretch))

    def energy_terms(self, stretch: tuple[float, float], state: Array) -> Mapping[str, float]:
        """Return the energies of stretching and of bending, J."""
        return total_energies(self.energies(stretch), state)

    def layer_states(
        self, energies: Sequence[Energy], state: Array, turn: Array
    ) -> list[LayerState]:
        """Return none: springs and hinges have no strain in the layers."""
        return []

    def reference_height(self, stretch: tuple[float, float]) -> float:
        """Return 0: the flat lattice is the flat bond, whichever neutral axis lies where."""
        return 0.0
