"""The least stiffness of a design's shape, and a search that keeps it."""

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from designing_task import small_task

from bilayer import design
from bilayer.designing import targets
from bilayer.designing.equilibria import Model, SheetMesh, find_shape
from bilayer.designing.report import report_text
from bilayer.designing.softness import least_stiffness
from bilayer.designing.trust_region import Limits
from bilayer.designing.variables import Variable, Variables
from bilayer.mesh.generation import generate_mesh
from bilayer.mesh.planar import flat_surface
from dshell.settings import MorleySettings
from dshell.solver import SOLVER

LEAST = 850.0
"""N/m3."""


@pytest.fixture(scope="module")
def task():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(targets, "NODES", 150)
        return small_task()


def stiffness_of(specimen, mesh):
    """By the inverse, as a design has it, and by the stiffness itself, as `states` has it."""
    sheet = SheetMesh(specimen, mesh)
    with closing(find_shape(Model(SOLVER, MorleySettings()), specimen, sheet)) as shape:
        areas = flat_surface(mesh).node_areas
        found = least_stiffness(shape.equilibrium, shape.linearised, areas)
        position = shape.equilibrium.position
    finder = SOLVER.open_finder(
        specimen, MorleySettings(), specimen.prestretch.milestones[-1], mesh=mesh
    )
    (own,) = finder.settle(position)
    return found, finder.stiffnesses(own, 1)[0]


def test_it_is_the_stiffness_that_states_lists(task):
    """Measured on the reference surface here, on the shell's own there: half a thickness away."""
    found, known = stiffness_of(task.specimen, generate_mesh(task.specimen))
    assert found == pytest.approx(known, rel=0.02)


def test_a_search_keeps_the_stiffness_that_is_wanted(task, tmp_path):
    """With more prestretch the shape comes nearer to the hemisphere, and becomes softer."""
    begin = task.specimen.with_layer("kirigami", thickness=2.5e-3).with_milestones([1.2])
    variables = Variables((Variable("prestretch", 1.1, 1.4),))
    wanted = replace(task, specimen=begin, variables=variables, limits=Limits(6))
    free = design(wanted, tmp_path / "free")
    kept = design(replace(wanted, least_stiffness=LEAST), tmp_path / "kept")
    stretches = [each.specimen.prestretch.milestones[0][0] for each in (free, kept)]
    assert stretches[0] > stretches[1] + 0.01
    assert 0 <= kept.along_the_way.margins[0] < 0.1
    assert kept.along_the_way.value > free.along_the_way.value
    assert np.isnan(free.along_the_way.shapes[0].stiffness)
    assert f"{1e-3 * LEAST:.3g} Pa/mm were wanted" in report_text(kept, [])
