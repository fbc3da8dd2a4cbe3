"""Whether the layers that lie on each triangle of a mesh can be those of a specimen."""

import numpy as np

from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen


def check_bonding(specimen: Specimen, mesh: PlanarMesh) -> None:
    """Raise InputError unless each triangle has layers without a gap, and the reference surface.

    Parameters
    ----------
    specimen : Specimen
        Its layers, from the bottom up.
    mesh : PlanarMesh
        Which of them lie on each triangle.
    """
    check_no_gap(specimen, mesh)
    surface, names = specimen.reference_surface, specimen.layer_names
    number = names.index(surface.layer)
    at_its_sides = {0.0: names[max(number - 1, 0) : number + 1], 1.0: names[number : number + 2]}
    bounded = at_its_sides.get(surface.share, (surface.layer,))
    without = [not mesh.layer_sets[region].intersection(bounded) for region in mesh.region]
    if any(without):
        raise InputError(
            f"layers.{surface.layer}.pattern: it is cut away on {sum(without)} triangles, expected "
            f"the reference surface, {surface}, everywhere on the sheet"
        )


def check_no_gap(specimen: Specimen, mesh: PlanarMesh) -> None:
    """Raise InputError if a layer is cut away somewhere between two layers that lie there.

    So it does if the mesh has layers that are not the specimen's.

    Parameters
    ----------
    specimen : Specimen
        Its layers, from the bottom up.
    mesh : PlanarMesh
        Which of them lie on each triangle.
    """
    for region in np.unique(mesh.region):
        unknown = sorted(mesh.layer_sets[region].difference(specimen.layer_names))
        if unknown:
            raise InputError(
                f"mesh: has triangles of a layer {unknown[0]!r}, expected layers of this specimen: "
                f"{', '.join(specimen.layer_names)}"
            )
        there = [name in mesh.layer_sets[region] for name in specimen.layer_names]
        lowest, highest = there.index(True), len(there) - 1 - there[::-1].index(True)
        if not all(there[lowest:highest]):
            gap = there.index(False, lowest)
            names = specimen.layer_names
            above = names[there.index(True, gap)]
            count = int(np.count_nonzero(mesh.region == region))
            raise InputError(
                f"layers.{names[gap]}.pattern: it is cut away between {names[gap - 1]} and {above} "
                f"on {count} triangles, expected no gap between layers that lie there"
            )
