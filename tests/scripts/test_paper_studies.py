"""The texts of the studies' scripts, and their changes of a mesh."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import paper_studies
import pytest
import xarray as xr
from studies.findings import (
    bounded,
    conclusions,
    contact_findings,
    most_important,
    no_points,
    optimum,
    points_of,
    range_findings,
    shift_verdict,
    spans_findings,
)
from studies.merged import with_contact
from studies.sensitivity import STEP, morphed, parameters

import bilayer
from bilayer.study.plan import read_study

COARSE = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.01)).with_milestones([1.03])

TINY = """
specimen = "specimen.toml"
solver = "dshell"
[settings.dshell]
model = "paper"
total_time = 0.002
[vary]
"cut.strips" = [4, 5]
"""


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


@pytest.mark.parametrize("solver", paper_studies.SOLVERS)
@pytest.mark.parametrize("name", paper_studies.NAMES)
def test_every_study_file_is_valid_and_has_its_solver(name, solver):
    for study in paper_studies.study_names(name, solver):
        plan = read_study(paper_studies.STUDIES / f"{study}.toml")
        assert solver in {case.solver for case in plan.cases}


@pytest.mark.parametrize("name", paper_studies.FIELDS)
def test_the_finite_elements_have_the_cases_of_the_shell(name):
    def cases(solver):
        studies = paper_studies.study_names(name, solver)
        plans = [read_study(paper_studies.STUDIES / f"{study}.toml") for study in studies]
        return [case for plan in plans for case in plan.cases]

    def values(solver):
        return {case.values[paper_studies.FIELDS[name]] for case in cases(solver)}

    assert values("fenics") == values("dshell")
    sizes = {case.specimen.mesh.size for solver in paper_studies.SOLVERS for case in cases(solver)}
    assert len(sizes) == 1


def test_points_with_contact_take_the_place_of_those_without_if_they_were_reached():
    field = "cut.strips"
    plain = made_study(field, [3, 4, 5], [0.5, 0.6, 0.7])
    plain["self_contact_gap"][1:] = 0.0
    pressing = made_study(field, [3, 4, 5, 6], [0.9, 0.61, 0.9, 0.8]).assign(
        contact_crosses=((field, "prestretch"), np.zeros((4, 1)))
    )
    pressing["converged"][2] = 0
    table = points_of(with_contact(plain, pressing), field)
    points = bounded({field: table})[field].set_index(field)
    assert points["quality"].tolist() == [0.5, 0.61, 0.7, 0.8]
    assert points["lowest"].tolist() == pytest.approx([0.5, 0.61, 0.69, 0.8])
    assert points["highest"].tolist() == pytest.approx([0.5, 0.61, 0.71, 0.8])
    assert "by at most 0.010, at 1 points" in contact_findings({field: table})[0]
    assert points["why"].tolist() == ["", "", "touches itself", ""]
    assert (points["solver"] == "dshell").all()
    nothing_known = bounded({field: points_of(plain, field)})[field]
    assert (nothing_known["highest"] - nothing_known["lowest"]).tolist() == [0, 1, 1]
    assert with_contact(plain) is plain
    uncomputed = pressing.drop_vars(["converged", "quality"])
    assert with_contact(plain, uncomputed) is plain


def test_a_case_that_is_not_computed_leaves_a_conclusion_open():
    points = judged("cut.strips", [0.4, 0.1, 0.4, np.nan], converged={3: np.nan})
    assert "a point was not computed (3 sound points of 4" in optimum(points, "cut.strips")
    assert "(1 not computed)" in "\n".join(range_findings(points, "cut.strips"))
    assert verdict(converged={1: np.nan}, quality={1: np.nan})[0].startswith("CANNOT BE DECIDED")


def test_what_is_computed_is_kept_drawn_and_told_and_not_computed_again(tmp_path, monkeypatch):
    specimen = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.016))
    text = bilayer.specimen_to_toml(specimen.with_milestones([1.03]))
    (tmp_path / "specimen.toml").write_text(text)
    (tmp_path / "strips.toml").write_text(TINY)
    monkeypatch.setattr(paper_studies, "STUDIES", tmp_path)
    monkeypatch.setattr(paper_studies, "RESULTS", tmp_path / "results")
    for _ in range(2):
        options = paper_studies.StudyOptions(jobs=1)
        paper_studies.run_studies(["strips"], ["dshell"], options)
    there = tmp_path / "results"
    assert (there / "strips_dshell.png").exists()
    told = (there / "findings.txt").read_text()
    assert "the most important, dshell: CANNOT BE DECIDED, a study is missing" in told
    with xr.open_dataset(there / "strips" / "scalars.nc") as scalars:
        assert scalars["quality"].sizes == {"cut.strips": 2, "prestretch": 1}
    assert str(tmp_path).encode() not in (there / "strips" / "scalars.nc").read_bytes()
    assert (there / "strips" / "study.log").read_text().count("begun") == 2


def judged(field, values, **change):
    """The points of a made study, changed at some places: {name: {place: value}}."""
    study = made_study(field, list(range(3, 3 + len(values))), values)
    for name, places in change.items():
        for place, value in places.items():
            study[name][place] = value
    return points_of(study, field)


def said_of_optimum(**change):
    return optimum(judged("cut.strips", [0.3, 0.1, 0.4], **change), "cut.strips")


def test_only_points_of_real_specimens_count():
    points = judged(
        "cut.strips",
        [0.1, 0.2, 0.3, 0.4],
        unstable_modes={0: 1},
        self_contact_gap={1: 0.0},
        converged={2: 0},
    )
    assert points["quality"][points["sound"]].tolist() == [0.4]
    said = "\n".join(range_findings(points, "cut.strips"))
    assert "1 sound points of 4 (1 unstable, 1 touches itself, 1 not reached)" in said
    assert "best 0.400 at cut.strips = 6" in said


def test_an_optimum_lies_between_sound_points_that_are_worse():
    assert said_of_optimum() == "holds, 4 (3 sound points of 3 at prestretch 1.15)"
    beside = said_of_optimum(unstable_modes={2: 1})
    assert beside.startswith("CANNOT BE DECIDED, a point beside the best: unstable (2 sound")
    at_the_end = said_of_optimum(quality={0: 0.05})
    assert at_the_end.startswith("does NOT hold, the best, 3, is an end of the interval")
    far = judged("cut.strips", [0.4, 0.1, 0.4, 0.05], unstable_modes={3: 1})
    assert "not sound may be better (3 sound points of 4" in optimum(far, "cut.strips")
    unknown = judged("cut.strips", [0.4, 0.1, 0.4, np.nan], converged={3: 0})
    assert "a point was not reached (3 sound points of 4" in optimum(unknown, "cut.strips")
    assert "no sound point" in said_of_optimum(converged={0: 0, 1: 0, 2: 0})


def verdict(strips=(0.2, 0.9), **change):
    """The verdict beside an angle's range of 0.4 and a radius' of 0.2, and the ranges."""
    points = {
        "cut.strips": judged("cut.strips", [*strips, 0.5]),
        "cut.cutout_angle": judged("cut.cutout_angle", [0.2, 0.6, 0.3], **change),
        "cut.inner_radius": judged("cut.inner_radius", [0.2, 0.4]),
    }
    return most_important(points, "dshell"), "\n".join(spans_findings(points))


def test_the_first_conclusion_is_judged_by_the_ranges():
    said, ranges = verdict()
    assert said == "holds at prestretch 1.15"
    assert "cut.cutout_angle 0.400 (3 of 3)" in ranges
    assert verdict(strips=(0.3, 0.4))[0] == "does NOT hold at prestretch 1.15"


def test_the_first_conclusion_is_open_where_a_point_that_does_not_count_could_turn_it():
    said, ranges = verdict(strips=(0.4, 0.7), unstable_modes={1: 1})
    assert "cut.cutout_angle 0.100 (2 of 3; at most 0.400)" in ranges
    assert said == "CANNOT BE DECIDED at prestretch 1.15"
    said, ranges = verdict(converged={1: 0}, quality={1: np.nan})
    assert "at most 1.000" in ranges
    assert said == "CANNOT BE DECIDED at prestretch 1.15"
    assert verdict(unstable_modes={2: 1})[0] == "holds at prestretch 1.15"


@pytest.mark.parametrize(("below", "said"), [(0.08, "holds"), (0.0, "does NOT hold")])
def test_the_shell_is_held_against_the_paper_s_shift(below, said):
    solid, shell = (
        judged("cut.strips", [quality]).assign(model=model)
        for quality, model in ((0.5, "solid"), (0.5 - below, "paper"))
    )
    points = pd.concat([solid, shell])
    assert shift_verdict(points, "paper").startswith(f"{said}, {below:+.3f} below in the mean")
    crossing = shift_verdict(points.assign(sound=False), "paper")
    assert crossing.startswith(f"{said}, ") and "of the 0 at which no shape passes" in crossing
    assert "no point of both" in shift_verdict(points[points["model"] == "solid"], "paper")


def test_shapes_that_pass_through_themselves_are_a_model_s_own_and_are_told():
    solid = judged("cut.strips", [0.5]).assign(model="solid")
    shell = judged("cut.strips", [0.42]).assign(model="paper")
    touching = shell.assign(prestretch=1.2, quality=0.9, sound=False)
    points = pd.concat([solid, solid.assign(prestretch=1.2), shell, touching])
    said = shift_verdict(points, "paper")
    assert said.startswith("does NOT hold, -0.160 below in the mean, 0.400 apart at most (2 ")
    assert "of the 1 at which no shape passes through itself +0.080 below" in said
    assert said.endswith("holds")
    lost = shift_verdict(pd.concat([points, solid.assign(prestretch=1.3)]), "paper")
    assert lost.startswith("CANNOT BE DECIDED, a point was not reached")


def test_every_conclusion_has_a_line_for_each_solver():
    fields = ("cut.strips", "cut.cutout_angle", "cut.inner_radius")
    points = {field: judged(field, [0.3, 0.1, 0.4]) for field in fields}
    lines = conclusions(points, judged("cut.strips", [0.5]))
    assert [line.partition(": ")[0] for line in lines[1:]] == [
        "  the number of the strips is the most important, dshell",
        "  cut.cutout_angle has an optimum, dshell",
        "  cut.inner_radius has an optimum, dshell",
        "  the shell is about 0.08 (by half of it more or less) below the finite elements "
        "(figure 6), morley",
    ]
    nothing = {field: no_points(field) for field in fields}
    assert conclusions(nothing, no_points()) == ["the paper's conclusions"]


@pytest.mark.parametrize("name", ["specimen.outer_radius", "cut.inner_radius", "cut.cutout_angle"])
def test_a_morphed_mesh_has_the_cuts_of_the_other_specimen(name):
    mesh = bilayer.generate_mesh(COARSE)
    other = parameters(COARSE)[name](1 + STEP)
    moved = morphed(mesh, COARSE, other)
    cut, radius = other.layer("kirigami").pattern, other.characteristic_length
    bare = moved.areas[moved.region == 0].sum()
    sectors = cut.strips * cut.cutout_angle / 2 * (radius**2 - cut.inner_radius**2)
    own = COARSE.layer("kirigami").pattern
    before = own.strips * own.cutout_angle / 2 * (0.04**2 - 0.008**2)
    flat = mesh.areas[mesh.region == 0].sum()
    assert bare / flat == pytest.approx(sectors / before, rel=3e-4)
    assert np.hypot(*moved.points.T).max() == pytest.approx(radius, rel=1e-12)


def test_a_stiffer_layer_has_every_modulus_higher():
    stiffer = parameters(COARSE)["substrate.young_modulus"](1.01)
    substrate, before = (s.layer("substrate").material for s in (stiffer, COARSE))
    ratio = substrate.young_modulus / before.young_modulus
    assert math.isclose(ratio, 1.01, rel_tol=1e-12)
    nu = substrate.poisson_ratio
    assert math.isclose(nu, before.poisson_ratio, rel_tol=1e-12)
    assert stiffer.layer("kirigami") == COARSE.layer("kirigami")
