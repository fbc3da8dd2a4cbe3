"""`result.bilayer`, and what a notebook shows."""

import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from made_results import cap_result, small_specimen

import bilayer
import bilayer.accessor  # as any public function does that returns a dataset
from bilayer.runtime import progress
from bilayer.runtime.progress import progress_asked
from bilayer.viewer.page import Page


@pytest.fixture(scope="module")
def result():
    return cap_result(reached=1.07)


def test_the_measures_are_a_table_of_the_milestones(result):
    table = result.bilayer.measures()
    assert table.index.tolist() == [1.03, 1.06, 1.09]
    assert table["height"].to_numpy() == pytest.approx(result["height"].values, nan_ok=True)
    assert table["span_y"].to_numpy() == pytest.approx(result["span"].values[:, 1], nan_ok=True)
    assert result.sel(prestretch=1.06).bilayer.measures()["height"].item() > 0


def test_the_shapes_are_drawn_and_shown(result):
    figure = result.bilayer.plot(views=["front"], milestones=[1.03])
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert isinstance(result.bilayer.view(result), Page)


def test_a_shape_for_pyvista(result):
    pytest.importorskip("pyvista")
    shape = result.bilayer.to_pyvista()
    np.testing.assert_array_equal(shape.points, result["position"].sel(prestretch=1.06).values)
    assert shape.n_cells == result.sizes["face"]
    assert shape.cell_data["region"].tolist() == result["region"].values.tolist()
    flat = shape.points - shape.point_data["displacement"]
    np.testing.assert_allclose(flat, result["reference_position"].values, atol=1e-15)
    with pytest.raises(bilayer.InputError, match=r"prestretch = 1.05: not in the result"):
        result.bilayer.to_pyvista(1.05)


def test_pyvista_that_is_not_there_is_named(result, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(bilayer.ComputationError, match="pyvista is not installed"):
        result.bilayer.to_pyvista()


def test_a_specimen_shows_its_layers_with_units_and_a_drawing():
    shown = replace(small_specimen(), name="<b>mine</b>")._repr_html_()
    assert "&lt;b&gt;mine&lt;/b&gt;" in shown
    for words in ("1 mm", "116.2 kPa", "mooney-rivlin", "substrate, stretched", "the whole sheet"):
        assert words in shown
    assert shown.index("kirigami") < shown.index("substrate")  # from the top
    drawing = ET.fromstring(shown[shown.index("<svg") : shown.index("</svg>") + len("</svg>")])
    below, above = (path.attrib["d"] for path in drawing.iter("path"))
    assert below.count("M") == 1
    assert above.count("L") > 20


@pytest.fixture
def reports():
    return []


@pytest.mark.parametrize(("asked", "notebook", "bar"), [
    (None, False, False), (None, True, True), (True, False, True), (False, True, False),
])  # fmt: skip
def test_a_bar_is_shown_in_a_notebook_or_if_asked(monkeypatch, asked, notebook, bar):
    monkeypatch.setattr(progress, "in_notebook", lambda: notebook)
    with progress_asked("dshell", asked) as report:
        assert (report is not None) is bar


def test_a_callback_is_called(reports):
    specimen = small_specimen((1.03,))
    bilayer.solve(specimen, "dshell", progress=lambda *report: reports.append(report))
    assert reports[-1] == (1.0, "prestretch 1.03")


def test_who_solves_has_the_accessor():
    program = (
        "import bilayer, sys; bilayer.open_result; import xarray as xr\n"
        "xr.Dataset().bilayer; assert 'matplotlib' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
