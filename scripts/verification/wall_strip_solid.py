"""The strip of `verification.wall_strip` by finite elements. SI units."""

from collections.abc import Iterator

import numpy as np

from fenics_model.mesh.volume_mesh import Slab, extrude
from fenics_model.release.specimen_solid import natural_state
from verification.rung import Check
from verification.solid_problem import equilibria, held_where, load_path, newton_of, solid_of
from verification.wall_strip import (
    BESIDE,
    KIRIGAMI,
    STRETCH,
    SUBSTRATE,
    missing,
    shell_angle,
    strip,
)


def solid_angle(width: float, elements: int, finest: float, growth: float = 1.5) -> float:
    """The angle of the strip's sides, with elements through each layer and a size at the walls.

    Parameters
    ----------
    width : float
        Of the bar, m.
    elements : int
        Through each layer.
    finest, growth : float
        Size of the elements at the walls, m, and how it grows away from them.
    """
    half = _graded(width / 2, finest, growth)
    beside = _graded(BESIDE, finest, growth)
    right = np.concatenate([width / 2 - half[::-1], width / 2 + beside[1:]])
    x = np.concatenate([-right[:0:-1], right])
    mesh = strip(x, width)
    layers = [Slab(SUBSTRATE.thickness, elements, mesh.triangles),
              Slab(KIRIGAMI.thickness, elements, mesh.triangles[mesh.region == 1])]  # fmt: skip
    volume = extrude(mesh, layers)
    solid = solid_of(volume, [SUBSTRATE.material, KIRIGAMI.material])
    near = volume.reference_surface[np.flatnonzero(mesh.points[:, 1] == 0)]
    first, last = near[[0, -1]]
    held = [
        held_where(solid, 1, lambda x: np.full(x.shape[1], True)),
        *solid.held_points([(first, 0), (first, 2), (last, 2)]),
    ]

    def load(parameter):
        natural = natural_state(((1 + parameter, 0.0), (0.0, 1.0)), "natural")
        solid.layers[0].natural.value = natural

    with newton_of(solid, held) as newton:
        (point,) = equilibria(load_path(newton, load, STRETCH - 1), [STRETCH - 1])
    line = solid.vertex_positions(point.state)[near][:, [0, 2]]
    slopes = [np.arctan2(*(line[b] - line[a])[::-1]) for a, b in ((0, 1), (-2, -1))]
    return abs(float(slopes[1] - slopes[0]))


def checks() -> Iterator[Check]:
    """What each wall takes from a bar, on coarse and fine sections, against the relieved shell."""
    for width in (4.8e-3, 19.2e-3):
        shell = missing(shell_angle(width, 8), width)
        bar = f"bar of {width / KIRIGAMI.thickness:g} t"
        for elements, finest in ((1, 1.6e-3), (2, 0.8e-3), (4, 0.2e-3), (8, 0.05e-3)):
            found = missing(solid_angle(width, elements, finest), width)
            case = f"{bar}, {elements} elements through, {1e3 * finest:g} mm: width taken / t"
            yield Check(case, found, shell, 0.02 if elements == 8 else None)


def _graded(length, first, growth):
    """Places from 0 to a length, ever farther apart up to 1 mm."""
    places = [0.0]
    while places[-1] < length:
        places.append(places[-1] + min(first * growth ** (len(places) - 1), 1e-3))
    return np.array(places) / places[-1] * length
