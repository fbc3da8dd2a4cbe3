"""The plan of a study: which cases, each valid, each named by what defines it."""

from dataclasses import replace

import numpy as np
import pytest
from studies_for_tests import write_study

from bilayer.errors import InputError
from bilayer.study.case import BYTES_OF_A_PROCESS
from bilayer.study.plan import _ascending, read_study
from bilayer.study.variation import product_rows, sampled_rows, zipped_rows

HEAD = 'specimen = "specimen.toml"\nsolver = "dshell"\n'


@pytest.fixture
def plan(tmp_path):
    return lambda text: read_study(write_study(tmp_path, text))


def test_the_product_of_lists_and_ranges(plan):
    study = plan(
        HEAD + '[vary]\n"cut.strips" = [3, 4]\n'
        '"cut.cutout_angle" = { start = 0.1, stop = 0.3, num = 3 }'
    )
    assert study.fields == ("cut.strips", "cut.cutout_angle")
    cuts = [c.specimen.layer("kirigami").pattern for c in study.cases]
    found = [(cut.strips, cut.cutout_angle) for cut in cuts]
    assert found == [(n, angle) for n in (3, 4) for angle in (0.1, 0.2, 0.3)]
    assert {c.model for c in study.cases} == {"morley"}


def test_names_of_fields_need_no_quotes(plan):
    quoted = (
        '[vary]\n"cut.strips" = [3, 4]\n'
        '"cut.cutout_angle" = { start = 0.1, stop = 0.3, num = 2 }\n'
        '[sample]\nn = 2\nseed = 1\n"substrate.young_modulus" = { low = 1e5, high = 2e5 }\n'
    )
    with_quotes, without = plan(HEAD + quoted), plan(HEAD + quoted.replace('"', ""))
    assert [c.identity for c in without.cases] == [c.identity for c in with_quotes.cases]
    assert without.fields == with_quotes.fields
    with pytest.raises(InputError, match=r"cut\.stripes"):
        plan(HEAD + "[vary]\ncut.stripes = [3]")


def test_a_range_is_the_list_of_the_same_numbers():
    assert product_rows({"a.b": {"start": 3, "stop": 8, "num": 6}}) == [
        {"a.b": n} for n in (3, 4, 5, 6, 7, 8)
    ]
    angles = [row["a.b"] for row in product_rows({"a.b": {"start": 0.1, "stop": 0.6, "num": 6}})]
    assert angles == [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]


def test_zipped_lists_go_side_by_side():
    assert zipped_rows({"a.b": [1, 2], "c.d": [3, 4]}) == [
        {"a.b": 1, "c.d": 3}, {"a.b": 2, "c.d": 4},
    ]  # fmt: skip


def test_a_latin_hypercube_has_one_point_in_every_slice_and_comes_again_with_its_seed():
    table = {"n": 8, "seed": 3, "a.b": {"low": 0.0, "high": 8.0}, "c.d": {"low": 1.0, "high": 2.0}}
    rows = sampled_rows(table)
    assert sorted(int(row["a.b"]) for row in rows) == list(range(8))
    assert sorted(int(8 * (row["c.d"] - 1)) for row in rows) == list(range(8))
    assert sampled_rows(table) == rows
    assert sampled_rows({**table, "seed": 4}) != rows


def test_a_sweep_of_the_prestretch_is_one_load_path(plan):
    study = plan(
        HEAD + '[vary]\n"prestretch.milestones" = [1.06, 1.03, [1.2, 1.1]]\n"cut.strips" = [4, 5]'
    )
    assert study.fields == ("cut.strips",)
    assert [c.specimen.prestretch.milestones for c in study.cases] == [
        ((1.03, 1.03), (1.06, 1.06), (1.2, 1.1))
    ] * 2


def test_zipped_prestretches_are_a_path_where_all_else_is_equal(plan):
    study = plan(
        HEAD + '[zip]\n"prestretch.milestones" = [1.03, 1.06, 1.09]\n"cut.strips" = [4, 4, 5]'
    )
    found = [
        (c.specimen.layer("kirigami").pattern.strips, c.specimen.prestretch.nominal)
        for c in study.cases
    ]
    assert found == [(4, [1.03, 1.06]), (5, [1.09])]


def test_settings_of_one_solver_make_no_more_cases_of_another(plan):
    study = plan(
        'specimen = "specimen.toml"\nsolver = ["dshell", "fenics"]\n'
        '[vary]\n"settings.dshell.model" = ["morley", "hinge"]\n'
    )
    assert [(c.solver, c.model) for c in study.cases] == [
        ("dshell", "morley"), ("dshell", "hinge"), ("fenics", "solid"),
    ]  # fmt: skip
    assert study.fields == ("solver", "settings.dshell.model")


def test_a_case_is_named_by_what_defines_it_alone(plan, tmp_path):
    text = HEAD + "[settings.dshell]\n{}\n[vary]\n{}\n"
    case = plan(text.format("", "")).cases[0]
    renamed = replace(case, specimen=replace(case.specimen, name="another"), values={"a.b": 1})
    assert renamed.identity == case.identity
    others = [
        plan(text.format(settings, field)).cases[0].identity
        for settings, field in [
            ('model = "hinge"', ""),
            ("tolerance = 1e-7", ""),
            ("", '"cut.cutout_angle" = [0.31]'),
            ("", '"substrate.young_modulus" = [116251.0]'),
            ("", '"mesh.size" = [0.013]'),
            ("", '"prestretch.milestones" = [1.03]'),
            ("", '"gravity.acceleration" = [9.81]'),
        ]
    ]
    assert len({case.identity, *others}) == 8
    stated = plan(text.format("tolerance = 1e-8", '"cut.strips" = [5]'))
    assert stated.cases[0].identity == case.identity


def test_a_case_that_is_not_valid_is_named_before_anything_runs(plan):
    with pytest.raises(InputError) as bad:
        plan(HEAD + '[vary]\n"cut.strips" = [5, 9]\n"cut.cutout_angle" = [0.3, 0.7, 0.71]')
    assert str(bad.value) == (
        "case 5 (cut.strips = 9, cut.cutout_angle = 0.7): cut.cutout_angle = 0.7 rad: 9 cutouts "
        "need less than 2*pi/9 = 0.6981 rad each, or they overlap "
        "(degrees as '20 deg') (and 1 more such cases)"
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "specimen = None: expected a file name"),
        ('specimen = "none.toml"\nsolver = "dshell"', "none.toml: cannot be read"),
        ('specimen = "specimen.toml"', "solver = None: expected one of"),
        ('specimen = "specimen.toml"\nsolver = []', "expected at least one"),
        ('specimen = "specimen.toml"\nsolver = "dshel"', "did you mean 'dshell'"),
        (HEAD + "vari = 1", "vari: unknown, .*did you mean 'vary'"),
        (HEAD + "vary = 1", "expected a table"),
        (HEAD + "[vary", "not a valid TOML file"),
        (HEAD + "[settings.fenics]", "settings = 'fenics': expected one of 'dshell'"),
        (HEAD + "[settings.dshell]\ntoleranc = 1.0", "did you mean 'tolerance'"),
        (HEAD + '[vary]\n"cut.strip" = [5]', "cut.strip: unknown key.*did you mean 'strips'"),
        (HEAD + '[vary]\n"cut.strips" = 5', "vary.cut.strips = 5: expected a list"),
        (HEAD + '[vary]\n"cut.strips" = []', "expected a list"),
        (HEAD + '[vary]\n"mesh.size" = { start = 0.1, num = 2 }', "mesh.size.stop: missing"),
        (HEAD + '[vary]\n"mesh.size" = { first = 0.1 }', "mesh.size.first: unknown key"),
        (HEAD + '[vary]\n"solver.tolerance" = [1.0]', "expected settings.dshell.tolerance"),
        (HEAD + '[vary]\n"settings.fenics.tolerance" = [1.0]', "expected one of 'dshell'"),
        (HEAD + '[vary]\n"settings.dshell.model" = ["papr"]', "did you mean 'paper'"),
        (HEAD + '[vary]\n"prestretch.milestones" = [1.03, "x"]', "expected a number"),
        (HEAD + '[zip]\n"cut.strips" = [5]\n"mesh.size" = [0.01, 0.02]', "of one length"),
        (
            HEAD + '[vary]\n"cut.strips" = [5]\n[zip]\n"cut.strips" = [5]',
            "cut.strips: given in two",
        ),
        (HEAD + "[sample]\nn = 3\nseed = 1", "expected at least one field"),
        (HEAD + '[sample]\nn = 3\n"mesh.size" = { low = 1, high = 2 }', "sample.seed: missing"),
        (
            HEAD + '[sample]\nn = 3\nseed = 1\n"mesh.size" = { low = 2, high = 1 }',
            "expected low below high",
        ),
    ],
)
def test_what_is_wrong_in_a_study_file_is_named(plan, text, message):
    with pytest.raises(InputError, match=message):
        plan(text)


@pytest.mark.parametrize(
    "given", [[1.2, [1.2, 1.0], [1.2, 1.1], 1.1], [[1.2, 1.1], 1.1, 1.2, [1.2, 1.0]]]
)
def test_milestones_of_one_larger_stretch_are_in_the_order_of_the_other(given):
    assert _ascending(given) == [1.1, [1.2, 1.0], [1.2, 1.1], 1.2]


def test_long_cases_cost_more(plan):
    study = plan(HEAD + '[vary]\n"mesh.size" = [0.01, 0.005]\n')
    coarse, fine = (case.cost for case in study.cases)
    assert np.isclose(fine / coarse, 4, rtol=0.1)


def test_more_elements_through_a_layer_take_more_memory(plan):
    text = 'specimen = "specimen.toml"\nsolver = "fenics"\n[vary]\n'
    study = plan(text + '"settings.fenics.substrate_elements" = [1, 3]\n')
    one, three = (case.memory - BYTES_OF_A_PROCESS for case in study.cases)
    assert three == pytest.approx(2 * one)
