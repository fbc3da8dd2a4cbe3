"""A result computed again from its own file: the same numbers, or it says that they are not."""

import shlex

import numpy as np
import pytest
from made_results import cap_result, small_specimen

from bilayer import open_result, write_result
from bilayer.cli.main import main
from bilayer.solvers.rerun import agree, differences, solve_command
from bilayer.specimen.toml import specimen_to_toml

SHELL = ["--solver", "dshell", "--model", "hinge", "--prestretch", "1.03", "1.06"]


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A result of the hinge model on a coarse mesh."""
    folder = tmp_path_factory.mktemp("rerun")
    (folder / "s.toml").write_text(specimen_to_toml(small_specimen()))
    path = folder / "a.nc"
    words = ["solve", str(folder / "s.toml"), *SHELL, "--set", "solver.ramp=0.02"]
    assert main([*words, "-o", str(path), "--quiet"]) == 0
    return path


def test_two_serial_runs_give_the_same_numbers_to_the_last_bit(stored, tmp_path, capsys):
    assert main(["rerun", str(stored), "-o", str(tmp_path / "b.nc")]) == 0
    assert "The two runs agree to the last bit." in capsys.readouterr().out
    first, again = open_result(stored), open_result(tmp_path / "b.nc")
    assert again.attrs["settings"] == first.attrs["settings"]
    assert "ramp = 0.02" in again.attrs["settings"]
    for name in ("position", "energy", "quality", "residual"):
        np.testing.assert_array_equal(again[name].values, first[name].values)


def test_an_interrupted_run_is_compared_as_far_as_it_came(stored, tmp_path, capsys):
    result = open_result(stored)
    result.attrs["stop_reason"] = "interrupted"
    result["converged"][1] = 0
    result["position"][1] = np.nan
    write_result(result, tmp_path / "half.nc")
    assert main(["rerun", str(tmp_path / "half.nc"), "-o", str(tmp_path / "b.nc")]) == 0
    assert "The two runs agree to the last bit." in capsys.readouterr().out
    assert open_result(tmp_path / "b.nc")["prestretch"].values.tolist() == [1.03]


def test_a_file_that_this_program_does_not_make_is_told(stored, tmp_path, capsys):
    result = open_result(stored)
    result["position"][1, 0, 2] += 1e-7
    write_result(result, tmp_path / "c.nc")
    assert main(["rerun", str(tmp_path / "c.nc"), "--quiet"]) == 1
    assert capsys.readouterr().out == "The two runs DO NOT AGREE.\n"


def test_the_commands_that_info_prints_compute_it_again(stored, tmp_path, capsys, monkeypatch):
    """Also where the mesh is not the one that the specimen would get."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(specimen_to_toml(small_specimen()))
    solve = ["solve", "s.toml", *SHELL, "--mesh", str(stored), "--set", "mesh.size=0.02"]
    assert main([*solve, "-o", "other.nc", "--quiet"]) == 0
    assert main(["info", "other.nc"]) == 0
    *_, write, compute = capsys.readouterr().out.splitlines()
    words, file = shlex.split(write), tmp_path / "again.toml"
    assert words[-2:] == [">", "again.toml"]
    assert main(words[1:-2]) == 0
    file.write_text(capsys.readouterr().out)
    assert main([*shlex.split(compute)[1:], "--quiet"]) == 0
    first, again = open_result("other.nc"), open_result("again.nc")
    np.testing.assert_array_equal(again["position"].values, first["position"].values)


def test_a_start_is_told_and_kept_where_it_can_be(stored, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(specimen_to_toml(small_specimen()))
    led = ["solve", "s.toml", *SHELL, "--start", str(stored), "-o", "led.nc", "--quiet"]
    assert main(led) == 0
    result = open_result("led.nc")
    assert result.attrs["start"].startswith("another result: dshell, model hinge")
    assert "--start START.nc" in solve_command(result, "led.nc")
    assert main(["rerun", "led.nc", "--quiet"]) == 0
    assert "which it does not hold" in capsys.readouterr().err
    stepped = open_result(stored).assign_attrs(solver="fenics", model="solid", settings="")
    assert "--start flat" in solve_command(stepped, "a.nc")


def test_differences_are_the_largest_of_each_variable():
    first = cap_result()
    second = first.copy(deep=True)
    second["height"][1] += 1e-3
    table = differences(first, second).set_index("variable")
    assert table.loc["height", "difference"] == pytest.approx(1e-3)
    assert not table.loc["height", "same_bits"]
    assert table.loc["position", "same_bits"]
    assert "wall_time" not in table.index
    assert agree(first, second)
    stopped = first.copy(deep=True)
    stopped["converged"][2] = 0
    stopped["position"][2] = np.nan
    assert not agree(first, stopped)
    assert np.isinf(differences(first, stopped).set_index("variable").loc["position", "difference"])


def test_info_prints_the_command_that_makes_a_result_again(stored, tmp_path, capsys):
    assert main(["info", str(stored), "--specimen"]) == 0
    (tmp_path / "again.toml").write_text(capsys.readouterr().out)
    assert main(["info", str(stored)]) == 0
    told = capsys.readouterr().out
    assert f"bilayer rerun {stored}" in told
    (line,) = [line for line in told.splitlines() if "bilayer solve" in line]
    words = line.split("bilayer solve again.toml ")[1].split()
    assert words == ["--solver", "dshell", "--model", "hinge", "--set", "solver.ramp=0.02",
                     "--mesh", str(stored), "-o", "again.nc"]  # fmt: skip
    words[-1] = str(tmp_path / "again.nc")
    assert main(["solve", str(tmp_path / "again.toml"), *words, "--quiet"]) == 0
    again = open_result(tmp_path / "again.nc")
    np.testing.assert_array_equal(again["position"].values, open_result(stored)["position"].values)
