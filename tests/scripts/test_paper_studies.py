"""What the studies' scripts say and how they change a mesh."""

import math
from dataclasses import replace

import numpy as np
import paper_studies
import pytest
import xarray as xr
from studies.findings import most_important, range_findings, sound_points
from studies.sensitivity import STEP, morphed, parameters

import bilayer
from bilayer.study.plan import read_study

COARSE = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.01)).with_milestones([1.03])


def made_study(field, values, quality):
    """A study of one solver over one field at prestretch 1.15, all sound."""
    dims = (field, "prestretch")
    table = np.array(quality)[:, None]
    return xr.Dataset(
        {
            "quality": (dims, table),
            "converged": (dims, np.ones_like(table)),
            "unstable_modes": (dims, np.zeros_like(table)),
            "self_contact_gap": (dims, np.full_like(table, np.inf)),
        },
        coords={
            field: values,
            "prestretch": [1.15],
            "solver": (field, ["dshell"] * len(values)),
            "model": (field, ["morley"] * len(values)),
        },
    )


@pytest.mark.parametrize("name", paper_studies.NAMES)
def test_every_study_file_is_valid_and_has_both_solvers(name):
    plan = read_study(paper_studies.STUDIES / f"{name}.toml")
    assert {case.solver for case in plan.cases} == {"dshell", "fenics"}
    assert {len(case.specimen.prestretch.milestones) for case in plan.cases} == {8}


def test_only_points_of_real_specimens_count():
    study = made_study("cut.strips", [3, 4, 5, 6], [0.1, 0.2, 0.3, 0.4])
    study["unstable_modes"][0] = 1
    study["self_contact_gap"][1] = 0.0
    study["converged"][2] = 0
    assert sound_points(study)["quality"].tolist() == [0.4]
    assert "best 0.400 at cut.strips = 6" in "\n".join(range_findings(study, "cut.strips"))


@pytest.mark.parametrize(("strips", "verdict"), [([0.2, 0.9], "holds"), ([0.2, 0.3], "NOT hold")])
def test_the_first_conclusion_is_judged_by_the_ranges(strips, verdict):
    studies = {
        "cut.strips": made_study("cut.strips", [3, 4], strips),
        "cut.cutout_angle": made_study("cut.cutout_angle", [0.3, 0.4], [0.2, 0.6]),
        "cut.inner_radius": made_study("cut.inner_radius", [0.01, 0.02], [0.2, 0.4]),
    }
    assert verdict in "\n".join(most_important(studies))


@pytest.mark.parametrize("name", ["specimen.outer_radius", "cut.inner_radius", "cut.cutout_angle"])
def test_a_morphed_mesh_has_the_cuts_of_the_other_specimen(name):
    mesh = bilayer.generate_mesh(COARSE)
    other = parameters(COARSE)[name](1 + STEP)
    moved = morphed(mesh, COARSE, other)
    cut, radius = other.cut, other.outer_radius
    bare = moved.areas[moved.region == 0].sum()
    sectors = cut.strips * cut.cutout_angle / 2 * (radius**2 - cut.inner_radius**2)
    before = COARSE.cut.strips * COARSE.cut.cutout_angle / 2 * (0.04**2 - 0.008**2)
    flat = mesh.areas[mesh.region == 0].sum()
    assert bare / flat == pytest.approx(sectors / before, rel=3e-4)
    assert np.hypot(*moved.points.T).max() == pytest.approx(radius, rel=1e-12)


def test_a_stiffer_layer_has_every_modulus_higher():
    stiffer = parameters(COARSE)["substrate.young_modulus"](1.01)
    ratio = stiffer.substrate.material.young_modulus / COARSE.substrate.material.young_modulus
    assert math.isclose(ratio, 1.01, rel_tol=1e-12)
    nu = stiffer.substrate.material.poisson_ratio
    assert math.isclose(nu, COARSE.substrate.material.poisson_ratio, rel_tol=1e-12)
    assert stiffer.kirigami == COARSE.kirigami
