"""`bilayer solve --solver both`: the shell, the finite elements, and how far they are apart."""

import json

import pytest

from bilayer import open_result
from bilayer.cli.main import main
from bilayer.specimen.toml import template


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "dome.toml").write_text(template())
    return tmp_path


def test_both_solvers_in_one_command(folder, capsys):
    words = ["solve", "dome.toml", "--solver", "both", "--mesh-size", "0.02", "--json"]
    assert main([*words, "--prestretch", "1.02", "--plot"]) == 0
    told = json.loads(capsys.readouterr().out)
    names = {path.name for path in folder.iterdir()}
    stems = ("dome_dshell", "dome_fenics")
    assert names == {"dome.toml"} | {f"{stem}.{end}" for stem in stems for end in ("nc", "png")}
    assert [open_result(f"{stem}.nc").attrs["solver"] for stem in stems] == ["dshell", "fenics"]
    assert [record["solver"] for record in told["results"]] == ["dshell", "fenics"]
    (row,) = told["comparison"]["milestones"]
    assert 0 < row["rms_distance_over_radius"] < 0.1


def test_both_solvers_have_no_settings_in_common(folder, capsys):
    words = ["solve", "dome.toml", "--solver", "both", "--set", "solver.tolerance=1e-6"]
    assert main(words) == 2
    assert "--solver both: expected neither --model" in capsys.readouterr().err
