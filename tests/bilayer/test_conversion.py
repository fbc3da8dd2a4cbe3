"""Results as mesh files: what ParaView and others read."""

import meshio
import numpy as np
import pytest
import xarray as xr
from made_results import cap_result

from bilayer import ComputationError, InputError, result_mesh
from bilayer.cli.main import main
from bilayer.exports.conversion import convert, convert_milestones
from bilayer.results.files import write_result


@pytest.fixture(scope="module")
def result():
    return cap_result(reached=1.06)


def test_every_reached_milestone_gets_a_file_of_its_own(result, tmp_path):
    written = convert_milestones(result, tmp_path / "shape.vtu")
    assert [path.name for path in written] == ["shape_1.03.vtu", "shape_1.06.vtu"]
    assert sorted(tmp_path.iterdir()) == sorted(written)


def test_without_a_prestretch_the_last_reached_shape_is_written(result, tmp_path):
    convert(result, tmp_path / "shape.vtu")
    last = result["position"].sel(prestretch=1.06).values
    assert meshio.read(tmp_path / "shape.vtu").points == pytest.approx(last, abs=1e-15)


@pytest.mark.parametrize("ending", ["vtu", "vtk"])
def test_the_shape_comes_back(result, tmp_path, ending):
    path = tmp_path / f"shape.{ending}"
    convert(result, path, prestretch=1.06)
    read = meshio.read(path)
    position = result["position"].sel(prestretch=1.06).values
    reference = result["reference_position"].values
    assert read.points == pytest.approx(position, abs=1e-15)
    assert read.point_data["displacement"] == pytest.approx(position - reference, abs=1e-15)
    assert read.point_data["reference_position"] == pytest.approx(reference, abs=1e-15)
    assert read.get_cells_type("triangle").tolist() == result["face_nodes"].values.tolist()
    assert read.get_cell_data("region", "triangle").tolist() == result["region"].values.tolist()


def with_volume(result):
    """The result with one layer of tetrahedra, its top the interface, to stand for a volume."""
    triangles = result_mesh(result).triangles
    top = result["position"].values
    nodes = len(top[0])
    below = np.concatenate([top, top - [0, 0, 1e-3]], axis=1)
    flat = np.concatenate([result["reference_position"].values] * 2)
    cells = np.column_stack([triangles + nodes, triangles[:, :1]])
    return result.merge(
        xr.Dataset(
            {
                "volume_position": (("prestretch", "volume_node", "xyz"), below),
                "volume_reference_position": (("volume_node", "xyz"), flat),
                "volume_cells": (("volume_cell", "vertex"), cells),
                "layer": ("volume_cell", np.zeros(len(cells), dtype=np.int32)),
            }
        )
    )


def test_the_volume_where_there_is_one(result, tmp_path):
    stacked = with_volume(result)
    path = tmp_path / "body.vtu"
    convert(stacked, path, prestretch=1.03, part="volume")
    read = meshio.read(path)
    assert read.get_cells_type("tetra").tolist() == stacked["volume_cells"].values.tolist()
    assert read.points == pytest.approx(stacked["volume_position"].values[0])
    assert set(read.get_cell_data("layer", "tetra")) == {0}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"prestretch": 1.09}, r"prestretch = 1\.09: expected .* reached \(1\.03, 1\.06\)"),
        ({"prestretch": 1.5}, r"prestretch = 1\.5"),
        ({"part": "midsurfaces"}, "did you mean 'midsurface'"),
    ],
)
def test_what_cannot_be_converted_is_said(result, tmp_path, options, message):
    with pytest.raises(InputError, match=message):
        convert(result, tmp_path / "shape.vtu", **options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", ["stl", "ply", "off", "obj"])
def test_a_volume_is_not_written_where_it_would_be_lost(result, tmp_path, capsys, ending):
    """meshio writes such a file without a single triangle."""
    with pytest.raises(InputError, match=rf"{ending}: holds triangles, no volume, expected an end"):
        convert(with_volume(result), tmp_path / f"shape.{ending}", part="volume")
    write_result(with_volume(result), tmp_path / "r.nc")
    words = ["convert", str(tmp_path / "r.nc"), "-o", str(tmp_path / f"shape.{ending}")]
    for more in ([], ["--all"]):
        assert main([*words, "--part", "volume", *more]) == 2
        assert "no volume, expected --solid for the closed surface" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["r.nc"]


def test_a_result_without_shapes(tmp_path):
    with pytest.raises(InputError, match="none was"):
        convert(cap_result(reached=1.01), tmp_path / "shape.vtu")


def test_an_unknown_format_writes_nothing(result, tmp_path):
    with pytest.raises(InputError, match=r"shape\.nonsense: cannot be written"):
        convert(result, tmp_path / "shape.nonsense", prestretch=1.03)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["shape.vtu", "shape.xdmf"])
def test_a_full_disk_leaves_nothing(result, tmp_path, full_disk, name):
    with full_disk(), pytest.raises(ComputationError, match=r"mesh file .* cannot be written"):
        convert(result, tmp_path / name, prestretch=1.03)
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_printed(result, tmp_path, capfd):
    for ending in ("vtu", "msh", "ply", "stl"):
        convert(result, tmp_path / f"shape.{ending}", prestretch=1.03)
    assert capfd.readouterr() == ("", "")
