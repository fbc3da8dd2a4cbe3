"""A design of a few evaluations, each a fraction of a second."""

import math
from dataclasses import replace

import bilayer
from bilayer.designing.targets import Target, cap
from bilayer.designing.task import DesignTask
from bilayer.designing.trust_region import Limits
from bilayer.designing.variables import Variable, Variables
from bilayer.designing.widths import LeastWidths

RADIUS = 0.04


def small_task() -> DesignTask:
    """Thickness, prestretch and one knot of the cutouts for a hemisphere."""
    pattern = bilayer.SectorProfile(5, (0.008, 0.019, 0.03, 0.04), (0.12, 0.16, 0.19, 0.24))
    specimen = bilayer.paper_specimen().with_layer("kirigami", pattern=pattern, thickness=1.5e-3)
    specimen = replace(specimen, mesh=bilayer.MeshSize(0.01)).with_milestones([1.12])
    bounds = {
        "prestretch": (1.05, 1.3),
        "kirigami.thickness": (0.5e-3, 3e-3),
        "kirigami.pattern.half_angles.3": (0.1, 0.4),
    }
    variables = Variables(tuple(Variable(name, *ends) for name, ends in bounds.items()))
    return DesignTask(
        specimen,
        Target(cap(2 * RADIUS / math.pi), "hemisphere"),
        variables,
        widths=LeastWidths(2e-3, 1e-3),
        limits=Limits(4),
    )
