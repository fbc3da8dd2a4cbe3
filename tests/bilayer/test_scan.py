"""A scan of the part against a result: which milestone it is, how far it is away."""

import json
import re
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import bilayer
from bilayer.cli.main import main
from bilayer.errors import InputError
from bilayer.geometry.surface import Surface
from bilayer.scan.cloud import Cloud, read_cloud
from bilayer.scan.comparison import best_match, compare_scan, scan_table, size_doubt
from bilayer.scan.placing import placed
from bilayer.scan.samples import even_samples

RESULT = Path(__file__).parents[2] / "results" / "paper" / "shell_morley.nc"
NOISE = 2e-4


@pytest.fixture(scope="module")
def result():
    """Three milestones of the paper's specimen."""
    return bilayer.open_result(RESULT).isel(prestretch=[1, 3, 5])


def surface_of(result, place):
    return Surface(result["position"].values[place], bilayer.result_mesh(result).triangles)


def scanned(surface, seed, count=4000):
    """Points of a surface with noise, outliers and a hole, turned and shifted at random."""
    rng = np.random.default_rng(seed)
    points = even_samples(surface, count).points
    points = points[np.linalg.norm(points - points[rng.integers(len(points))], axis=1) > 8e-3]
    points = points + rng.normal(0, NOISE, points.shape)
    outliers = rng.random(len(points)) < 0.1
    points[outliers] += rng.normal(0, 5e-3, (outliers.sum(), 3))
    turn = Rotation.random(random_state=rng).as_matrix()
    return points @ turn.T + rng.normal(0, 0.1, 3)


@pytest.mark.parametrize("seed", range(4))
def test_noise_outliers_a_hole_and_any_position(result, seed):
    place = seed % 3
    matches = compare_scan(result, Cloud("made", scanned(surface_of(result, place), seed)))
    assert best_match(matches) == place
    assert matches[place].rms == pytest.approx(NOISE, rel=0.03)
    assert 0.07 < matches[place].outliers.mean() < 0.12
    assert matches[place].coverage > 0.95
    assert all(m.rms > 2 * NOISE for k, m in enumerate(matches) if k != place)


def test_a_scan_without_noise_lies_on_its_shape(result):
    surface = surface_of(result, 1)
    turn = Rotation.from_rotvec([0.3, -2.0, 1.0]).as_matrix()
    points = even_samples(surface, 3000).points @ turn.T + [0.1, -0.2, 0.3]
    samples = even_samples(surface, 20_000)
    distance = samples.nearest(placed(points, samples).moved(points)).distance
    assert np.quantile(np.abs(distance), 0.95) < 2e-5
    assert (
        np.abs(distance).max() < 3e-4
    )  # beside an edge the nearest sample is in the next triangle


def test_distances_are_positive_above_the_shape_and_from_the_rim_beyond_it():
    square = Surface(
        np.array([(0.0, 0, 0), (0.04, 0, 0), (0.04, 0.04, 0), (0, 0.04, 0)]),
        np.array([(0, 1, 2), (0, 2, 3)]),
    )
    samples = even_samples(square, 20_000)
    points = np.array([(0.02, 0.02, 0.001), (0.01, 0.01, -0.002), (0.05, 0.02, 0.0)])
    distance = samples.nearest(points).distance
    assert distance[:2] == pytest.approx([0.001, -0.002], rel=1e-9)
    assert abs(distance[2]) == pytest.approx(0.01, rel=0.05)


def test_samples_lie_evenly(result):
    surface = surface_of(result, 2)
    samples = even_samples(surface, 10_000)
    assert len(samples.points) == 10_000
    assert np.linalg.norm(samples.normals, axis=1) == pytest.approx(np.ones(10_000))
    assert samples.points.mean(axis=0) == pytest.approx(surface.centroid, abs=1e-4)


@pytest.mark.parametrize("ending", [".stl", ".ply", ".obj"])
def test_meshes_are_read_in_their_unit(tmp_path, result, ending):
    surface = surface_of(result, 0)
    cells = [("triangle", surface.triangles)]
    meshio.write(tmp_path / f"part{ending}", meshio.Mesh(1e3 * surface.points, cells))
    cloud = read_cloud(tmp_path / f"part{ending}")
    assert cloud.points.mean(axis=0) == pytest.approx(surface.centroid, abs=1e-4)


@pytest.mark.parametrize("text", ["x,y,z\n{}", "{}", "# scanned\nx;y;z\n{}"])
def test_tables_of_points_are_read(tmp_path, text):
    rows = "\n".join(f"{k},{k * k},{-k}" for k in range(30))
    (tmp_path / "points.csv").write_text(text.format(rows))
    cloud = read_cloud(tmp_path / "points.csv", 1e-2)
    assert cloud.points[3] == pytest.approx([0.03, 0.09, -0.03])


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.doc", "", "expected a name in .stl"),
        ("a.csv", "x,y\n1,2\n", "expected at least 20 points"),
        ("a.csv", "1,2,three\n", "expected 3 numbers on each line"),
        ("a.csv", "nan,1,2\n" * 30, "finite coordinates"),
        ("a.stl", "solid nothing", "expected at least 20 points"),
    ],
)
def test_what_is_no_scan_is_refused(tmp_path, name, text, words):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=words):
        read_cloud(tmp_path / name)


def test_the_verb(tmp_path, capsys, result):
    surface = surface_of(result, 1)
    cells = [("triangle", surface.triangles)]
    meshio.write(tmp_path / "part.stl", meshio.Mesh(1e3 * surface.points, cells))
    bilayer.write_result(result, tmp_path / "three.nc")
    words = ["compare", str(tmp_path / "three.nc"), str(tmp_path / "part.stl")]
    assert main([*words, "-o", str(tmp_path / "map.png")]) == 0
    table = capsys.readouterr().out
    assert [line.split()[2] for line in table.splitlines() if "*" in line] == ["1.12"]
    assert (tmp_path / "map.png").stat().st_size > 20_000
    assert main([*words, "--unit", "kg"]) == 2
    assert "--unit" in capsys.readouterr().err
    assert main(["compare", words[2], words[1]]) == 2
    assert "expected the result first, then the scan" in capsys.readouterr().err


def test_the_distance_is_a_field_on_the_shape(result):
    """A scan that lies 0.4 mm above around the middle, and has a hole in a petal."""
    surface = surface_of(result, 1)
    samples = even_samples(surface, 8000)
    points = samples.points
    middle = surface.points[np.linalg.norm(bilayer.result_mesh(result).points, axis=1).argmin()]
    lifted = np.linalg.norm(points - middle, axis=1) < 8e-3
    noise = np.random.default_rng(1).normal(0, NOISE, len(points))
    points = points + (noise + 4e-4 * lifted)[:, None] * samples.normals
    points = points[np.linalg.norm(points - surface.points[0], axis=1) > 6e-3]
    scan = Cloud("lifted", points @ Rotation.from_rotvec([0.4, 1.0, -2.0]).as_matrix().T)
    fields = bilayer.distance_to_scan(result, scan, compare_scan(result, scan))
    distance = fields["distance_to_scan"].values[1]
    assert 0.9 < np.isfinite(distance).mean() < 1
    away = np.linalg.norm(surface.points - middle, axis=1)
    inside, outside = np.nanmean(distance[away < 6e-3]), np.nanmean(distance[away > 1e-2])
    assert inside - outside == pytest.approx(4e-4, rel=0.15)
    field = bilayer.scalar_field(fields, "distance_to_scan")
    assert (field.unit, field.location) == ("mm", "node")


def test_the_verb_writes_the_field_and_the_distances_both_ways(tmp_path, capsys, result):
    bilayer.write_result(result.isel(prestretch=[1]), tmp_path / "one.nc")
    np.savetxt(tmp_path / "scan.csv", 1e3 * scanned(surface_of(result, 1), 3), delimiter=",")
    words = ["compare", str(tmp_path / "one.nc"), str(tmp_path / "scan.csv")]
    assert main([*words, "-o", str(tmp_path / "map.vtu")]) == 0
    ways = capsys.readouterr().out.splitlines()[-4:]
    assert re.fullmatch(r"λ = 1.12, mm \(% of the diagonal of .* mm\)", ways[0])
    assert ways[1].split() == ["rms", "mean", "95", "%", "largest"]
    for line, way in zip(ways[2:], ("scan to shape", "shape to scan"), strict=True):
        shares = re.fullmatch(way + r" +" + r" +".join([r"([\d.]+) \([\d.]+ %\)"] * 4), line)
        rms, mean, most, largest = map(float, shares.groups())
        assert 0 < mean < rms < most < largest < 5
    written = meshio.read(tmp_path / "map.vtu")
    assert np.nanmax(np.abs(written.point_data["distance_to_scan [m]"])) < 1e-3
    assert main([*words, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert 0 < record["milestones"][0]["back"]["rms"] < 2e-3


@pytest.mark.parametrize(("unit", "doubtful"), [(1e-3, True), (1.0, False), (25.4, True)])
def test_a_scan_in_another_unit_is_doubted(result, unit, doubtful):
    scan = Cloud("part.stl", unit * surface_of(result, 1).points)
    assert ("is --unit right" in size_doubt(result, scan)) is doubtful


def test_the_table_marks_the_best(result):
    matches = compare_scan(result, Cloud("made", scanned(surface_of(result, 2), 7)))
    lines = scan_table(matches).splitlines()
    assert ["*" in line for line in lines] == [False, False, False, True]
