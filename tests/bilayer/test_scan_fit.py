"""The parameter that fits a scan best, and results on other meshes against each other."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from made_results import cap_result, small_specimen

import bilayer
from bilayer import InputError, MeshSize
from bilayer.cli.main import main
from bilayer.geometry.surface import Surface
from bilayer.results.files import write_result
from bilayer.results.other_mesh import positions_on
from bilayer.results.released_shapes import released_shapes
from bilayer.scan.cloud import Cloud, read_cloud
from bilayer.scan.profile import edge_of
from bilayer.scan.samples import even_samples
from bilayer.solvers.scan_fit import fit_to_scan

NOISE = 5e-5


@pytest.fixture(scope="module")
def specimen():
    return replace(bilayer.paper_specimen(), mesh=MeshSize(0.01)).with_milestones([1.03, 1.06])


@pytest.fixture(scope="module")
def result(specimen):
    return bilayer.solve(specimen, "dshell")


def scan_of(specimen, mesh, seed):
    """A scan of a part that differs from the result's specimen."""
    rng = np.random.default_rng(seed)
    shape = bilayer.solve(specimen, "dshell", mesh=mesh)["position"].values[0]
    points = even_samples(Surface(shape, mesh.triangles), 1500).points
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    return Cloud("made", (points + rng.normal(0, NOISE, points.shape)) @ turn.T + 0.05)


def test_another_parameter(specimen, result):
    mesh = bilayer.result_mesh(result)
    other = specimen.with_layer("kirigami", thickness=0.85e-3).with_milestones([1.06])
    found = fit_to_scan(result, scan_of(other, mesh, 2), "kirigami.thickness")
    assert found.value == pytest.approx(0.85e-3, rel=0.02)
    with pytest.raises(InputError, match=r"parameter = 'kirigami\.colour'"):
        fit_to_scan(result, scan_of(other, mesh, 2), "kirigami.colour")


def test_the_prestretch_of_a_scan_between_two_milestones(specimen, result, tmp_path, capsys):
    file, points = tmp_path / "a.nc", tmp_path / "scan.csv"
    write_result(result, file)
    scan = scan_of(specimen.with_milestones([1.05]), bilayer.result_mesh(result), 3)
    np.savetxt(points, 1e3 * scan.points, delimiter=",", header="x,y,z", comments="")
    words = ["compare", str(file), str(points), "--fit", "prestretch"]
    assert main([*words, "-o", str(tmp_path / "map.png")]) == 0
    said = capsys.readouterr().out
    value, rms = re.search(r"prestretch = (\S+) fits best \(rms (\S+) mm\)", said).groups()
    assert float(value) == pytest.approx(1.05, abs=1e-3)
    assert float(rms) < 3e3 * NOISE and "bound" not in said
    assert main(["compare", str(file), str(file), "--fit", "prestretch"]) == 2
    assert "expected no second result" in capsys.readouterr().err


def test_the_prestretch_of_a_profile(specimen, result, tmp_path, capsys):
    """The edge of a shape between two milestones, as in a photograph."""
    file, points = tmp_path / "a.nc", tmp_path / "edge.csv"
    write_result(result, file)
    mesh = bilayer.result_mesh(result)
    seen = bilayer.solve(specimen.with_milestones([1.05]), "dshell", mesh=mesh)
    (shape,) = released_shapes(seen, mesh)
    surface = Surface(1e-3 * shape.surface.points, mesh.triangles)
    edge = edge_of(even_samples(surface, 20_000).points, np.radians(10))
    np.savetxt(points, 1e3 * edge + [200, 30], delimiter=",", header="x,z", comments="")
    words = ["compare", str(file), str(points), "--profile", "--fit", "prestretch", "--json"]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)["fit"]
    assert found["value"] == pytest.approx(1.05, abs=1e-3)
    assert found["rms"] < 1e-4


def test_a_shape_on_another_mesh_is_the_same_shape():
    """A cap at the nodes of a finer mesh."""
    coarse = cap_result(small_specimen((1.06,)))
    finer = replace(small_specimen((1.06,)), mesh=MeshSize(0.006))
    exact = cap_result(finer)
    meshes = [bilayer.result_mesh(each) for each in (exact, coarse)]
    found = positions_on(*meshes, coarse["position"].values)
    assert np.abs(found - exact["position"].values).max() < 3e-4
    same = coarse["position"].values
    assert positions_on(meshes[1], meshes[1], same) is same


def test_results_on_two_meshes_are_compared(tmp_path, capsys):
    coarse, finer = small_specimen(), replace(small_specimen(), mesh=MeshSize(0.006))
    one, other = cap_result(coarse), cap_result(finer)
    compared = bilayer.compare(one, other)
    assert (compared["rms_distance"].values < 1e-4).all()
    assert "interpolated" in compared.attrs["meshes"]
    assert "meshes" not in bilayer.compare(one, one).attrs
    distance = bilayer.fields(one, other)["distance_to_other"].values
    assert np.isfinite(distance).all() and distance.max() < 5e-4
    for name, result in (("a", one), ("b", other)):
        write_result(result, tmp_path / f"{name}.nc")
    assert main(["compare", str(tmp_path / "a.nc"), str(tmp_path / "b.nc")]) == 0
    assert "interpolated at the nodes of the first" in capsys.readouterr().out


def test_a_height_map_with_gaps_is_a_scan(tmp_path):
    """A table over a grid; places without a height are left out."""
    x, y = np.meshgrid(np.linspace(-30, 30, 41), np.linspace(-30, 30, 41))
    z = np.sqrt(80.0**2 - x**2 - y**2)
    rows = [f"{a},{b},{c}" for a, b, c in zip(x.flat, y.flat, z.flat, strict=True)]
    rows[3], rows[7] = rows[3].rsplit(",", 1)[0] + ",", rows[7].rsplit(",", 1)[0] + ",nan"
    (tmp_path / "map.csv").write_text("x,y,z\n" + "\n".join(rows))
    cloud = read_cloud(tmp_path / "map.csv")
    assert len(cloud.points) == 41 * 41 - 2
    assert np.linalg.norm(cloud.points, axis=1) == pytest.approx(0.08)
