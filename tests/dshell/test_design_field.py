"""A field of density: its energy, its derivatives, and a design from field to pattern."""

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

import bilayer
from bilayer import InputError
from bilayer.designing import targets
from bilayer.designing.equilibria import Model, SheetMesh, find_shape
from bilayer.designing.fields import GREY_WEIGHT, cut_out, grey_penalty, with_sharpness
from bilayer.designing.targets import Target, cap
from bilayer.designing.task import Check, DesignTask
from bilayer.designing.trust_region import Limits
from bilayer.designing.variables import Variable, Variables, value_of, with_values
from bilayer.designing.widths import LeastWidths
from bilayer.mesh.planar import flat_surface
from bilayer.specimen.toml import specimen_to_toml
from dshell.settings import MorleySettings
from dshell.solver import SOLVER

MODEL = Model(SOLVER, MorleySettings(tolerance=1e-11))
SIDE = 0.05


def sheet(shares, sharpness=0.0, mirrors="none"):
    """A square bilayer with a field of 3 x 3 nodes."""
    count = 3
    field = bilayer.DensityField(SIDE, SIDE, count, count, tuple(shares), mirrors, sharpness)
    base = bilayer.paper_specimen()
    layers = (base.layer("substrate"), replace(base.layer("kirigami"), pattern=field))
    outline = bilayer.Rectangle(SIDE, SIDE)
    return bilayer.Specimen(
        outline, layers, base.prestretch, bilayer.MeshSize(0.009)
    ).with_milestones([1.06])


def test_a_full_field_is_a_whole_layer_and_an_empty_one_is_none():
    full = bilayer.solve(sheet([1.0] * 9), "dshell")
    whole = sheet([1.0] * 9).with_layer("kirigami", pattern=None)
    known = bilayer.solve(whole, "dshell", mesh=bilayer.generate_mesh(sheet([1.0] * 9)))
    assert np.allclose(full["position"], known["position"], atol=1e-9)
    empty = bilayer.solve(sheet([0.0] * 9), "dshell")
    assert float(empty["span_long"][-1] if "span_long" in empty else empty["height"][-1]) < SIDE
    flat = empty["position"].values[-1]
    assert np.ptp(flat[:, 2]) < 1e-6
    assert np.ptp(flat[:, 0]) == pytest.approx(SIDE / 1.06, rel=1e-3)  # the substrate alone


@pytest.mark.parametrize("name", ["kirigami.share.0", "kirigami.share.4", "kirigami.thickness"])
def test_the_remainder_is_of_second_order(name):
    """Taylor's test of a smooth function of the shape that no rigid motion changes."""
    rng = np.random.default_rng(2)
    specimen = sheet(rng.uniform(0.2, 0.8, 9), sharpness=3.0)
    mesh = SheetMesh(specimen, bilayer.generate_mesh(specimen))
    ends = rng.integers(0, len(mesh.mesh.points), (2, 300))

    def bonds(position):
        return position[ends[0]] - position[ends[1]]

    with closing(find_shape(MODEL, specimen, mesh)) as shape:
        position = shape.equilibrium.position
        by_position = np.zeros_like(position)
        np.add.at(by_position, ends[0], 2 * bonds(position))
        np.add.at(by_position, ends[1], -2 * bonds(position))
        (slope,) = shape.gradient(by_position, [name])
        saved, change = shape.equilibrium.save(), shape.state_changes([name])[0]
    value, remainders = (bonds(position) ** 2).sum(), []
    first = 0.02 * (value_of(specimen, name) if "thickness" in name else 1.0)
    for step in first * 0.5 ** np.arange(3):
        there = with_values(specimen, {name: value_of(specimen, name) + step})
        with closing(find_shape(MODEL, there, mesh, saved, step * change)) as moved:
            found = (bonds(moved.equilibrium.position) ** 2).sum()
        remainders.append(abs(found - value - step * slope))
    rates = np.log2(np.array(remainders[:-1]) / remainders[1:])
    assert rates.min() > 1.9, (remainders, slope, value)


def test_the_weight_of_a_field_is_that_of_its_share():
    from dshell.models.masses import lumped_masses

    specimen = sheet([0.25] * 9)
    mesh = bilayer.generate_mesh(specimen)
    whole, part = (
        lumped_masses(each, mesh, (1.0, 1.0)).sum()
        for each in (specimen.with_layer("kirigami", pattern=None), specimen)
    )
    kirigami = specimen.layer("kirigami")
    missing = 0.75 * kirigami.density * kirigami.thickness * flat_surface(mesh).areas.sum()
    assert whole - part == pytest.approx(missing)


def test_other_models_refuse_a_field():
    for settings in (bilayer.HingeSettings(), bilayer.MorleySettings(walls="relieved")):
        with pytest.raises(InputError, match="density-field"):
            bilayer.solve(sheet([0.5] * 9), "dshell", settings)


@pytest.fixture(scope="module")
def task():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(targets, "NODES", 150)
        target = Target(cap(0.04, 0.6), "cap")
    begin = sheet([0.5] * 6, mirrors="diagonals")
    names = [f"kirigami.share.{k}" for k in range(6)]
    variables = Variables((Variable("prestretch", 1.02, 1.3), *(Variable(n, 0, 1) for n in names)))
    return DesignTask(
        begin, target, variables, least_gap=0.0, limits=Limits(3), sharpness=(0.0, 4.0)
    )


def test_a_design_sharpens_its_field(task, tmp_path):
    outcome = bilayer.design(task, tmp_path / "d")
    assert outcome.specimen.layer("kirigami").pattern.sharpness == 4.0
    assert outcome.from_flat.shapes[0].distance < 0.7 * outcome.history[0].distances[0]
    assert {tried.stage for tried in outcome.history} >= {1, 2}
    again = bilayer.design(task, tmp_path / "d")
    assert np.array_equal(again.from_flat.point, outcome.from_flat.point)


def test_the_pattern_that_is_cut_out_is_read_back_as_a_drawing(tmp_path):
    """From the cut file of the report to a specimen whose sheet is meshed anew."""
    field = sheet([1.0, 0.9, 0.1, 0.8, 0.2, 0.0, 0.3, 0.1, 0.9])
    cut = cut_out(field)
    bilayer.write_cut_files(cut, tmp_path / "parts.dxf")
    tables = specimen_to_toml(cut)
    (tmp_path / "cut.toml").write_text(tables)
    drawing = "{ drawing = 'parts-kirigami.dxf', layer = 'cut', what = 'kept' }"
    read = bilayer.read_specimen(tmp_path / "cut.toml", [f"layers.kirigami.pattern={drawing}"])
    apart = [each.layer("kirigami").pattern.kept(each.outline) for each in (cut, read)]
    assert apart[0].symmetric_difference(apart[1]).area < 1e-4 * cut.outline.area


def test_what_a_field_cannot_have_is_refused(task):
    with pytest.raises(InputError, match="density-field is cut out"):
        replace(task, check=Check(2))
    plain = task.specimen.with_layer("kirigami", pattern=None)
    names = Variables((Variable("prestretch", 1.02, 1.3),))
    with pytest.raises(InputError, match="sharpness"):
        replace(task, specimen=plain, variables=names)


def test_what_is_between_none_and_all_costs_more_as_it_is_sharper():
    rng = np.random.default_rng(5)
    specimen = sheet(rng.uniform(0.1, 0.9, 9), sharpness=6.0)
    mesh = bilayer.generate_mesh(specimen)
    names = ["prestretch", "kirigami.share.4"]
    value, slopes = grey_penalty(specimen, mesh, names)
    step = 1e-4
    there = with_values(specimen, {names[1]: value_of(specimen, names[1]) + step})
    assert grey_penalty(there, mesh, names)[0] - value == pytest.approx(step * slopes[1], rel=1e-2)
    assert slopes[0] == 0.0
    assert grey_penalty(with_sharpness(specimen, 0.0), mesh, names)[0] == 0.0
    assert grey_penalty(cut_out(specimen), mesh, names[:1])[0] == 0.0
    half = sheet([0.5] * 9, sharpness=20.0)
    assert grey_penalty(half, mesh, names)[0] == pytest.approx(GREY_WEIGHT)


def test_what_was_cut_out_can_be_designed_further(tmp_path):
    """Its thicknesses and prestretch; the cuts stay."""
    field = sheet([1.0, 0.9, 0.1, 0.8, 0.2, 0.0, 0.3, 0.1, 0.9])
    variables = Variables((Variable("prestretch", 1.02, 1.3),))
    task = DesignTask(
        cut_out(field), Target(cap(0.04, 0.6), "cap"), variables, least_gap=0.0, limits=Limits(4)
    )
    outcome = bilayer.design(task, tmp_path / "d")
    assert outcome.from_flat.shapes[0].distance < outcome.history[0].distances[0]
    with pytest.raises(InputError, match="whose mesh can"):
        replace(task, widths=LeastWidths(1e-3))
