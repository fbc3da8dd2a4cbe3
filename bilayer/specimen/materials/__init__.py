"""Material laws, each one class: constants, their keys in a file, moduli, energy, natural state."""

from bilayer.specimen.materials.arruda_boyce import ArrudaBoyce
from bilayer.specimen.materials.gent import Gent
from bilayer.specimen.materials.hyperelastic import Hyperelastic
from bilayer.specimen.materials.jet import Jet
from bilayer.specimen.materials.law import Functions, Law
from bilayer.specimen.materials.linear import LinearElastic
from bilayer.specimen.materials.mooney_rivlin import MooneyRivlin
from bilayer.specimen.materials.neo_hookean import NeoHookean
from bilayer.specimen.materials.ogden import Ogden
from bilayer.specimen.materials.registry import (
    LAWS,
    law_from_table,
    law_keys,
    law_to_table,
    register_law,
)
from bilayer.specimen.materials.stability import (
    StabilityLimits,
    loss_of_stability,
    stability_limits,
    stability_warning,
)
from bilayer.specimen.materials.yeoh import Yeoh

__all__ = [
    "LAWS",
    "ArrudaBoyce",
    "Functions",
    "Gent",
    "Hyperelastic",
    "Jet",
    "Law",
    "LinearElastic",
    "MooneyRivlin",
    "NeoHookean",
    "Ogden",
    "StabilityLimits",
    "Yeoh",
    "law_from_table",
    "law_keys",
    "law_to_table",
    "loss_of_stability",
    "register_law",
    "stability_limits",
    "stability_warning",
]
