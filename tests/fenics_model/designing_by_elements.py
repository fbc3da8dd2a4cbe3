"""A small design that the finite-element model checks, or whose search it ends."""

import math
from dataclasses import replace

import pytest

import bilayer
from bilayer.designing import targets
from bilayer.designing.targets import Target, cap
from bilayer.designing.task import Check, DesignTask
from bilayer.designing.trust_region import Limits
from bilayer.designing.variables import Variable, Variables


def task_of(evaluations: int, check: Check) -> DesignTask:
    """A thickness for a hemisphere, on coarse meshes."""
    sheet = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.013)).with_milestones([1.03])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(targets, "NODES", 150)
        target = Target(cap(0.08 / math.pi), "hemisphere")
    return DesignTask(
        sheet,
        target,
        Variables((Variable("kirigami.thickness", 0.8e-3, 1.3e-3),)),
        least_gap=0.0,
        limits=Limits(evaluations),
        check=check,
    )


def task_ended_by_elements() -> DesignTask:
    """One evaluation by the shell, two by the finite-element model, and a check."""
    return task_of(1, Check(1, evaluations=2))
