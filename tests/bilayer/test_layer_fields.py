"""The layers on each face of a result, to the file and back."""

import numpy as np
import pytest
import xarray as xr
from grids import grid_mesh, rectangle

from bilayer import Layer, MooneyRivlin, PlanarMesh, Prestretch, Rectangle, Response, Specimen
from bilayer.results.layer_fields import layer_sets_of, layer_variables
from bilayer.results.schema import result_mesh

TAPE = MooneyRivlin(4839.1, 14536.0)


def sheet(*names):
    layers = [Layer(name, 1e-3, TAPE) for name in names]
    layers[0] = Layer(names[0], 1e-3, TAPE, response=Response("path"))
    return Specimen(Rectangle(0.04, 0.01), layers, Prestretch([1.1]))


def mesh_of(*sets):
    grid = grid_mesh(rectangle(4, 1), 0.01)
    region = np.arange(len(grid.triangles)) % len(sets)
    return PlanarMesh(grid.points, grid.triangles, region, [frozenset(names) for names in sets])


@pytest.mark.parametrize(
    ("specimen", "mesh"),
    [
        (sheet("film"), mesh_of({"film"})),
        (sheet("low", "core", "high"), mesh_of({"core"}, {"low", "core"}, {"high", "core", "low"})),
        (sheet("substrate", "kirigami"), mesh_of({"substrate"}, {"kirigami", "substrate"})),
    ],
    ids=["one", "three", "two"],
)
def test_the_layers_of_each_face_come_back_from_a_file(specimen, mesh, tmp_path):
    flat = np.pad(mesh.points, ((0, 0), (0, 1)))
    planar = {
        "reference_position": (("node", "xyz"), flat),
        "face_nodes": (("face", "corner"), mesh.triangles),
    }
    xr.Dataset(planar | layer_variables(specimen, mesh)).to_netcdf(tmp_path / "layers.nc")
    with xr.open_dataset(tmp_path / "layers.nc") as stored:
        read = stored.load()
    assert result_mesh(read).same_as(mesh)
    for name in specimen.layer_names:
        there = read["layers_present"].sel(layer_name=name).values
        assert np.array_equal(np.flatnonzero(there), mesh.faces_of(name))


def test_a_bilayer_has_the_words_of_older_files():
    variables = layer_variables(
        sheet("substrate", "kirigami"), mesh_of({"substrate"}, {"kirigami", "substrate"})
    )
    assert variables["region"][2]["flag_meanings"] == "bare kirigami"


def test_a_set_without_a_layer_stays_empty():
    sets = (frozenset(), frozenset({"film"}))
    grid = grid_mesh(rectangle(4, 1), 0.01)
    mesh = PlanarMesh(grid.points, grid.triangles, np.ones(len(grid.triangles)), sets)
    assert layer_sets_of(xr.Dataset(layer_variables(sheet("film"), mesh))) == sets
