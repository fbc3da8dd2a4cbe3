"""The page that shows a result: what it holds, that it is small and needs nothing else."""

import base64
import json
import re

import numpy as np
import pytest
import xarray as xr
from made_results import cap_result

import bilayer
from bilayer.cli.main import main
from bilayer.results.files import write_result
from bilayer.viewer.page import view
from bilayer.viewer.scene import STEPS

TURN = np.array([[0.5, -np.sqrt(0.75), 0], [np.sqrt(0.75), 0.5, 0], [0, 0, 1]])


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return cap_result()


def scene_in(text: str) -> dict:
    found = re.search(r'<script type="application/json" id="scene">(.*?)</script>', text, re.S)
    return json.loads(found[1])


def numbers(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype=kind)


def test_a_page_holds_the_shapes(result):
    model = scene_in(view(result).text)["models"][0]
    mesh = bilayer.result_mesh(result)
    assert model["titles"] == ["λ = 1.03", "λ = 1.06", "λ = 1.09"]
    points = numbers(model["positions"], "<i2").reshape(3, model["nodes"], 3) * model["scale"]
    shown = np.linalg.norm(points[1] - points[1].mean(axis=0), axis=1)
    position = 1e3 * result["position"].values[1]
    assert np.abs(shown - np.linalg.norm(position - position.mean(axis=0), axis=1)).max() < 0.01
    faces = numbers(model["faces"], "<u4").reshape(-1, 3)
    assert sorted(map(tuple, faces)) == sorted(map(tuple, mesh.triangles))
    assert sum(region["count"] for region in model["regions"]) == len(faces)
    first = model["regions"][0]["count"]
    assert model["regions"][0]["name"] == "bilayer"
    kirigami = {tuple(mesh.triangles[face]) for face in mesh.faces_of("kirigami")}
    assert {tuple(face) for face in faces[:first]} == kirigami


def test_the_height_is_a_field_and_a_cap_lies_on_its_sphere(result):
    fields = scene_in(view(result).text)["models"][0]["fields"]
    by_name = {field["name"]: field for field in fields}
    assert list(by_name) == ["height", "distance from the best sphere"]
    assert by_name["height"]["low"] == 0.0
    steps = numbers(by_name["height"]["values"], "<i2")
    assert steps.min() == 0 and steps.max() == STEPS
    sphere = by_name["distance from the best sphere"]
    assert max(abs(sphere["low"]), abs(sphere["high"])) < 1e-3


def test_a_second_result_is_laid_over_the_first(result):
    """Another motion of the same shapes is no distance; a missing milestone is not shown."""
    fewer = cap_result(motion=lambda x: x @ TURN.T + 0.01).isel(prestretch=[0, 2])
    first, second = scene_in(view(result, fewer).text)["models"]
    assert second["places"] == [0, -1, 1]
    distance = next(
        f for f in first["fields"] if f["name"].startswith("distance from shell (paper)")
    )
    assert distance["high"] < 1e-6
    steps = numbers(distance["values"], "<i2").reshape(3, -1)
    assert (steps[1] == -1).all() and (steps[[0, 2]] >= 0).all()


def test_a_page_is_small_and_needs_nothing_else(result):
    text = view(result).text
    assert len(text) < 500_000
    assert not re.search(r"""(src|href)\s*=|@import|url\(|fetch\(|XMLHttpRequest|https?://""", text)
    assert "{{" not in text


def test_names_cannot_end_the_program(result):
    named = result.assign_attrs(model="</script><script>alert(1)//")
    text = view(named, title="<b>&").text
    assert text.count("<script") == 2 and "<title>&lt;b&gt;&amp;</title>" in text
    assert scene_in(text)["models"][0]["name"].endswith("</script><script>alert(1)//")


def test_a_notebook_shows_it_in_a_frame(result):
    page = view(result)
    frame = page._repr_html_()
    assert frame.startswith("<iframe srcdoc=") and "<script" not in frame


def test_the_verb(tmp_path, result, capsys, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open_new_tab", opened.append)
    write_result(result, tmp_path / "cap.nc")
    assert main(["view", str(tmp_path / "cap.nc"), "--no-open"]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "cap.html") and not opened
    assert main(["view", str(tmp_path / "cap.nc"), "-o", str(tmp_path / "b.html"), "--quiet"]) == 0
    assert opened == [(tmp_path / "b.html").as_uri()]
    assert main(["view", str(tmp_path / "cap.nc"), "-o", str(tmp_path / "b.png")]) == 2
    assert "expected a name in .html" in capsys.readouterr().err
