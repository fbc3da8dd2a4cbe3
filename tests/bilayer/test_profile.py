"""Profiles from photographs: the edge of a shape seen from the side, and which milestone it is."""

import json
from pathlib import Path

import numpy as np
import pytest

import bilayer
from bilayer import InputError
from bilayer.cli.main import main
from bilayer.geometry.surface import Surface
from bilayer.results.files import write_result
from bilayer.results.released_shapes import released_shapes
from bilayer.scan.profile import Profile, compare_profile, edge_of, read_profile
from bilayer.scan.samples import even_samples

RESULT = Path(__file__).parents[2] / "results" / "paper" / "shell_morley.nc"
NOISE = 1e-4


@pytest.fixture(scope="module")
def result():
    return bilayer.open_result(RESULT).isel(prestretch=[1, 3, 5])


def edge_in_a_picture(result, place, azimuth, seed):
    """Part of the edge of a milestone, shifted, with noise."""
    shape = released_shapes(result, bilayer.result_mesh(result))[place]
    surface = Surface(1e-3 * shape.surface.points, shape.surface.triangles)
    edge = edge_of(even_samples(surface, 30_000).points, azimuth)[::2]
    rng = np.random.default_rng(seed)
    return edge[5:-5] + rng.normal(0, NOISE, edge[5:-5].shape) + [0.3, -0.2]


def test_the_edge_of_a_hemisphere_is_a_half_circle():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(200_000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points[:, 2] = np.abs(points[:, 2])
    edge = edge_of(points, 0.7)
    assert np.linalg.norm(edge, axis=1) == pytest.approx(1.0, abs=0.01)
    assert (np.diff(edge[:, 0]) > 0).all()


@pytest.mark.parametrize("place", [0, 2])
def test_a_profile_finds_its_milestone(result, place):
    seen = edge_in_a_picture(result, place, np.radians(40), place)
    matches = compare_profile(result, Profile("made", seen))
    rms = [match.rms for match in matches]
    assert int(np.argmin(rms)) == place
    assert rms[place] < 4 * NOISE and sorted(rms)[1] > 1.5 * rms[place]


def test_a_profile_on_the_command_line(result, tmp_path, capsys):
    file, edge = tmp_path / "a.nc", tmp_path / "edge.csv"
    write_result(result, file)
    seen = 1e3 * edge_in_a_picture(result, 1, 0.3, 5)
    np.savetxt(edge, seen, delimiter=",", header="x,z", comments="")
    assert main(["compare", str(file), str(edge), "--profile"]) == 0
    starred = next(line for line in capsys.readouterr().out.splitlines() if "*" in line)
    titles = [shape.title for shape in released_shapes(result, bilayer.result_mesh(result))]
    assert starred.startswith(titles[1])
    assert read_profile(edge).points == pytest.approx(1e-3 * seen, rel=1e-9)
    words = ["compare", str(file), str(edge), "--profile", "--json"]
    assert main([*words, "-o", str(tmp_path / "edge.png")]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["best"] == titles[1] and (tmp_path / "edge.png").stat().st_size > 10_000
    assert record["milestones"][1]["rms"] < 4 * NOISE < record["milestones"][0]["rms"]
    assert main([*words, "-o", str(tmp_path / "map.vtu")]) == 2


def test_bad_profiles_are_refused():
    with pytest.raises(InputError, match="expected at least 5 points"):
        Profile("a", np.zeros((3, 2)))
    with pytest.raises(InputError, match="finite"):
        Profile("a", np.full((9, 2), np.inf))
