"""Where the barrier of a specimen begins to act, and how stiff it is: the same in both solvers."""

from bilayer.specimen.specimen import Specimen

STIFFNESS = 0.03
"""Of the barrier, over Young's modulus of the softest layer: a few times the pressures that a bent
sheet bears. A stiffer barrier keeps places farther apart in its range and asks for more iterations:
on the paper's specimen up to 29 at 0.1 where it asks for 12 at 0.03."""


def barrier_range(specimen: Specimen, share: float) -> float:
    """Return the distance from which on nothing acts, m: a share of the thickness of all layers."""
    return share * sum(layer.thickness for layer in specimen.layers)


def barrier_stiffness(specimen: Specimen) -> float:
    """Return the stiffness of the barrier, Pa."""
    return STIFFNESS * min(layer.material.young_modulus for layer in specimen.layers)
