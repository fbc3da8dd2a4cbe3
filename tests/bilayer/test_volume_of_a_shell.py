"""Layers of a shell as prisms, and data of an export in other axes and units."""

import meshio
import numpy as np
import pytest
from made_results import cap_result

import bilayer
from bilayer.exports.conversion import convert
from bilayer.exports.frame import Axes


@pytest.fixture(scope="module")
def caps():
    return cap_result(reached=1.06)


def test_the_prisms_hold_the_natural_volume(caps, tmp_path):
    convert(caps, tmp_path / "body.vtu", part="volume")
    read = meshio.read(tmp_path / "body.vtu")
    cells, layer = read.get_cells_type("wedge"), read.get_cell_data("layer", "wedge")
    mesh, specimen = bilayer.result_mesh(caps), bilayer.result_specimen(caps)
    below, above = (read.points[cells[:, part]] for part in (slice(0, 3), slice(3, 6)))
    middle = (below + above) / 2
    area = np.cross(middle[:, 1] - middle[:, 0], middle[:, 2] - middle[:, 0]) / 2
    height = (above - below).mean(axis=1)
    volume = np.sum(area * height, axis=1)
    assert (volume > 0).all()
    for number, name in enumerate(specimen.layer_names):
        flat = mesh.areas[mesh.faces_of(name)].sum()
        whole = flat * specimen.bonded_layer(name, (1.06, 1.06)).thickness
        assert volume[layer == number].sum() == pytest.approx(whole, rel=0.02)


def test_cells_have_the_fields_of_their_layer(caps, tmp_path):
    fields = bilayer.fields(caps)
    convert(caps, tmp_path / "body.vtu", part="volume", fields=fields)
    read = meshio.read(tmp_path / "body.vtu")
    thinning = read.get_cell_data("layer_prestretch", "wedge")[:, 2]
    layer = read.get_cell_data("layer", "wedge")
    assert thinning[layer == 0] == pytest.approx(1.06**-2)
    assert thinning[layer == 1] == pytest.approx(1.0)


def test_the_body_frame_in_mm(caps, tmp_path):
    """Apex up, the rim about z = 0, 1000 times as large; normals turn along, fields stay in SI."""
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    turned = cap_result(reached=1.06, motion=lambda points: points @ turn.T + 0.3)
    fields = bilayer.fields(turned)
    for part in ("midsurface", "volume"):
        convert(turned, tmp_path / "a.vtu", part=part, fields=fields, axes=Axes("body", "mm"))
        read = meshio.read(tmp_path / "a.vtu")
        assert np.ptp(read.points, axis=0)[:2] == pytest.approx([78, 78], abs=4)
        assert -3 < read.points[:, 2].min() < 1
        moved = read.points - read.point_data["reference_position"]
        assert read.point_data["displacement"] == pytest.approx(moved, abs=1e-12)
    convert(turned, tmp_path / "a.vtu", fields=fields, axes=Axes("body", "mm"))
    read = meshio.read(tmp_path / "a.vtu")
    assert (read.point_data["normal"][:, 2] > 0.8).all()
    curvature = fields["mean_curvature"].isel(prestretch=1).values
    assert read.point_data["mean_curvature [m-1]"] == pytest.approx(curvature)


@pytest.mark.parametrize("given", [("bodyframe", "m"), ("body", "cm")])
def test_other_axes_are_refused(given):
    with pytest.raises(bilayer.InputError, match="expected one of"):
        Axes(*given)
