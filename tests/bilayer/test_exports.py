"""Time series that ParaView plays, and solids that slicers take."""

import sys
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from made_results import cap_result
from shapes import cap
from sheets import EXAMPLE_SPECIMENS

import bilayer
from bilayer import ComputationError, InputError
from bilayer.cli.main import main
from bilayer.exports.conversion import convert
from bilayer.exports.frame import Axes
from bilayer.exports.series import SERIES, convert_series
from bilayer.exports.solid import SOLIDS, convert_solid, solid_of
from bilayer.results.assembly import Provenance, build_result
from bilayer.results.files import write_result
from bilayer.results.schema import MilestoneState
from bilayer.specimen.schedule import Schedule

pyvista = pytest.importorskip("pyvista")
trimesh = pytest.importorskip("trimesh")


@pytest.fixture(scope="module")
def caps():
    return cap_result(reached=1.06)


def test_pyvista_opens_the_series_with_its_times_and_names(caps, tmp_path):
    fields = bilayer.fields(caps)
    names = convert_series(caps, tmp_path / "shape.pvd", "volume", fields=fields)
    assert [name.name for name in names] == ["shape.pvd", "shape_0.vtu", "shape_1.vtu"]
    assert sorted(tmp_path.iterdir()) == sorted(names)
    reader = pyvista.get_reader(str(names[0]))
    assert reader.time_values == [1.03, 1.06]
    heights = []
    for time in reader.time_values:
        reader.set_active_time_value(time)
        (grid,) = reader.read()
        assert {"displacement", "layer", "layer_prestretch"} <= set(grid.array_names)
        heights.append(np.ptp(grid.points[:, 2]))
    assert 0 < heights[0] < heights[1] < 0.05


@pytest.mark.parametrize("part", ["midsurface", "volume"])
def test_one_file_holds_what_the_files_of_a_series_hold(caps, tmp_path, part):
    pytest.importorskip("h5py")
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF")
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline

    fields = bilayer.fields(caps)
    (name,) = convert_series(caps, tmp_path / "shape.vtkhdf", part, fields=fields)
    names = convert_series(caps, tmp_path / "shape.pvd", part, fields=fields)
    reader, files = vtk.vtkHDFReader(), pyvista.get_reader(str(names[0]))
    reader.SetFileName(str(name))
    reader.UpdateInformation()
    key = Pipeline.TIME_STEPS()
    assert list(reader.GetOutputInformation(0).Get(key)) == files.time_values == [1.03, 1.06]
    for step in range(reader.GetNumberOfSteps()):
        reader.SetStep(step)
        reader.Update()
        files.set_active_time_point(step)
        one, (other,) = pyvista.wrap(reader.GetOutput()), files.read()
        assert np.array_equal(one.points, other.points)
        assert np.array_equal(one.cell_connectivity, other.cell_connectivity)
        assert np.array_equal(one.celltypes, other.celltypes)
        assert set(one.array_names) - {"Time"} == set(other.array_names)
        for array in other.array_names:
            assert np.array_equal(one[array], other[array], equal_nan=True), array


def test_a_series_of_times_has_them(tmp_path):
    sheet = bilayer.paper_specimen().with_milestones([1.06])
    slow = replace(sheet, schedule=Schedule((0.0, 10.0, 300.0), 60.0))
    convert_series(cap_result(slow), tmp_path / "slow.pvd")
    assert pyvista.get_reader(str(tmp_path / "slow.pvd")).time_values == [0.0, 10.0, 300.0]


def test_a_loop_of_prestretches_has_numbers_for_times(tmp_path):
    loop = cap_result(bilayer.paper_specimen().with_milestones([1.03, 1.06, 1.03]))
    (tmp_path / "l").mkdir()
    convert_series(loop, tmp_path / "l" / "a.pvd", axes=Axes("body", "mm"))
    reader = pyvista.get_reader(str(tmp_path / "l" / "a.pvd"))
    assert reader.time_values == [0.0, 1.0, 2.0]
    (grid,) = reader.read()
    assert 60 < np.ptp(grid.points[:, 0]) < 81
    assert "region" in grid.array_names


@pytest.mark.parametrize("ending", SERIES)
def test_a_full_disk_leaves_no_part_of_a_series(caps, tmp_path, full_disk, ending):
    with full_disk(), pytest.raises(ComputationError, match=r"time series .* cannot be written"):
        convert_series(caps, tmp_path / f"a{ending}")
    assert list(tmp_path.iterdir()) == []


def test_without_h5py_the_other_series_is_named(caps, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(ComputationError, match=r"needs the package h5py .*or write a \.pvd"):
        convert_series(caps, tmp_path / "a.vtkhdf")
    assert list(tmp_path.iterdir()) == []


def example_result(path: Path):
    """A cap of the example's sheet at its last milestone, on a coarse mesh."""
    specimen = bilayer.read_specimen(path)
    size = max(specimen.mesh.size, specimen.characteristic_length / 7)
    specimen = bilayer.read_specimen(path, [f"mesh.size={size}"])
    specimen = specimen.with_milestones(specimen.prestretch.milestones[-1:])
    mesh = bilayer.generate_mesh(specimen)
    length = specimen.characteristic_length
    position = cap(mesh.points - mesh.centroid, 0.4, length)
    made_by = Provenance("dshell", "morley", "", "", "")
    return build_result(specimen, mesh, [MilestoneState(position, True, 1.0)], made_by)


@pytest.mark.parametrize("path", EXAMPLE_SPECIMENS, ids=lambda path: path.stem)
def test_the_solid_of_every_example_is_closed_and_turned_outward(path, tmp_path):
    result = example_result(path)
    specimen, mesh = bilayer.result_specimen(result), bilayer.result_mesh(result)
    convert_solid(result, tmp_path / "solid.stl")
    body = trimesh.load(tmp_path / "solid.stl")  # its corners come together again
    assert body.is_watertight and body.is_winding_consistent
    stretch = specimen.prestretch.milestones[0]
    natural = sum(
        mesh.areas[mesh.faces_of(layer.name)].sum() * layer.thickness
        for layer in specimen.bonded_layers(stretch)
    )
    assert body.volume / 1e9 == pytest.approx(natural, rel=0.05)


@pytest.mark.parametrize("ending", SOLIDS)
def test_formats_and_their_units(caps, tmp_path, ending):
    """80 mm across, in mm or, in glTF, m, where y is upward."""
    path = tmp_path / f"solid{ending}"
    convert_solid(caps, path, 1.03)
    body = trimesh.load(path, force="mesh")
    assert body.is_watertight and body.volume > 0
    across, tall = np.sort(body.extents)[-1], np.sort(body.extents)[0]
    scale = 1e-3 if ending == ".glb" else 1.0
    assert across == pytest.approx(81 * scale, rel=0.05)
    assert list(body.extents).index(tall) == (1 if ending == ".glb" else 2)


def test_a_volume_gives_its_own_boundary(caps):
    """Two tetrahedra on a face make a body of six triangles."""
    import xarray as xr

    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.3, 1], [0.3, 0.3, -1]])
    volume = {
        "volume_position": (("prestretch", "volume_node", "xyz"), np.array([points] * 3)),
        "volume_reference_position": (("volume_node", "xyz"), points),
        "volume_cells": (("volume_cell", "vertex"), np.array([[0, 1, 2, 3], [0, 1, 2, 4]])),
    }
    solid = solid_of(caps.merge(xr.Dataset(volume)).isel(prestretch=0), Axes())
    body = trimesh.Trimesh(solid.points, solid.triangles, process=False)
    assert len(solid.triangles) == 6 and body.is_watertight
    assert body.volume == pytest.approx(1 / 3)


def test_layers_that_touch_in_a_line_are_no_solid(caps):
    import xarray as xr

    points = np.array([[0.0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    volume = {
        "volume_position": (("prestretch", "volume_node", "xyz"), np.array([points] * 3)),
        "volume_reference_position": (("volume_node", "xyz"), points),
        "volume_cells": (("volume_cell", "vertex"), np.array([[0, 1, 2, 3], [0, 1, 4, 5]])),
    }
    with pytest.raises(ComputationError, match="1 edges have not one triangle on either side"):
        solid_of(caps.merge(xr.Dataset(volume)).isel(prestretch=0), Axes())


def test_convert_on_the_command_line(caps, tmp_path, capsys):
    result = tmp_path / "caps.nc"
    write_result(caps, result)
    words = ["convert", str(result), "-o"]
    assert main([*words, str(tmp_path / "a.pvd"), "--all", "--part", "volume", "--unit", "mm"]) == 0
    assert main([*words, str(tmp_path / "a.stl"), "--solid", "--prestretch", "1.03"]) == 0
    assert np.ptp(trimesh.load(tmp_path / "a.stl").vertices, axis=0)[0] > 70
    for wrong in (["a.vtu", "--solid"], ["b.stl", "--solid", "--all"], ["b.pvd", "--prestretch=1"]):
        assert main([*words, str(tmp_path / wrong[0]), *wrong[1:]]) == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "a.pvd", "a.stl", "a_0.vtu", "a_1.vtu", "caps.nc"
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "words", "scale"),
    [("a.stl", [], 1e3), ("a.ply", ["--unit", "m"], 1.0), ("a.vtu", [], 1.0), ("a.OFF", [], 1e3)],
)
def test_formats_of_slicers_and_scanners_are_in_mm(caps, tmp_path, name, words, scale):
    write_result(caps, tmp_path / "caps.nc")
    written = tmp_path / name
    assert main(["convert", str(tmp_path / "caps.nc"), "-o", str(written), "--quiet", *words]) == 0
    flat = np.ptp(caps["position"].sel(prestretch=1.06).values[:, 0])
    assert np.ptp(meshio.read(written).points[:, 0]) == pytest.approx(scale * flat, rel=1e-5)
    if not words:
        convert(caps, tmp_path / f"again{name}")
        assert (tmp_path / f"again{name}").read_bytes() == written.read_bytes()


def test_endings_are_checked(caps, tmp_path):
    with pytest.raises(InputError, match=r"expected a name in \.pvd or \.vtkhdf"):
        convert_series(caps, tmp_path / "a.vtu")
    with pytest.raises(InputError, match="ending of solid"):
        convert_solid(caps, tmp_path / "a.step")
