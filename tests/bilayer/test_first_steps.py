"""What a user meets first: one word is enough, nothing is replaced unsaid, help that helps."""

import argparse
import json
import os
import subprocess
import sys
from math import isfinite

import pytest
from made_results import cap_result, small_specimen

from bilayer import open_result, write_result
from bilayer.cli.main import _parser, main
from bilayer.cli.verbs import VERBS
from bilayer.specimen.settings import describe
from bilayer.specimen.toml import template
from dshell.settings import MorleySettings

COARSE = ["--mesh-size", "0.012", "--prestretch", "1.03"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty current folder with the paper's specimen in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "dome.toml").write_text(template())
    return tmp_path


@pytest.fixture
def result_file(folder):
    write_result(cap_result(), folder / "caps.nc")
    return folder / "caps.nc"


def json_of(capsys, *words):
    assert main([*words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_solve_needs_no_more_than_the_specimen(folder, capsys):
    assert main(["solve", "dome.toml", *COARSE, "--plot"]) == 0
    assert {path.name for path in folder.iterdir()} == {"dome.toml", "dome.nc", "dome.png"}
    assert open_result("dome.nc").attrs["model"] == "morley"


def test_a_dome_in_one_command(folder, monkeypatch, capsys):
    coarse = (
        template().replace("size = 0.003", "size = 0.012").replace("1.15, 1.18, 1.21, 1.24", "1.15")
    )
    monkeypatch.setattr("bilayer.cli.demo.template", lambda: coarse)
    assert main(["demo", "-o", "first"]) == 0
    told = capsys.readouterr().out
    files = {f"first.{ending}" for ending in ("toml", "nc", "png", "html")}
    assert {path.name for path in folder.iterdir()} == files | {"dome.toml"}
    assert all(name in told for name in files)
    assert "bilayer solve first.toml --plot --overwrite" in told
    assert open_result("first.nc")["converged"].all()
    assert main(["demo", "-o", "first"]) == 2
    assert "first.toml: is there already, expected --overwrite" in capsys.readouterr().err


def test_a_result_that_nobody_named_is_not_replaced(folder, capsys):
    (folder / "dome.nc").write_text("of an hour")
    assert main(["solve", "dome.toml", *COARSE]) == 2
    assert "dome.nc: is there already, expected --overwrite" in capsys.readouterr().err
    assert (folder / "dome.nc").read_text() == "of an hour"
    assert main(["solve", "dome.toml", *COARSE, "--overwrite", "--quiet"]) == 0
    assert open_result("dome.nc")["converged"].all()


def test_a_result_that_is_replaced_is_said(folder, capsys):
    words = ["solve", "dome.toml", *COARSE, "-o", "mine.nc"]
    (folder / "mine.nc").write_text("of an hour")
    assert main(words) == 0
    assert "bilayer: mine.nc: replaced the file that was there\n" in capsys.readouterr().err
    assert main([*words, "--quiet"]) == 0
    assert "replaced" not in capsys.readouterr().err


def test_of_a_picture_that_is_replaced_nothing_is_said(result_file, capsys):
    words = ["compare", str(result_file), str(result_file), "-o", "c.png"]
    assert main(words) == 0
    assert main(words) == 0
    assert capsys.readouterr().err == ""


def test_settings_are_listed_by_model(capsys):
    assert main(["settings"]) == 0
    listed = capsys.readouterr().out
    for model in ("solid", "morley", "hinge", "paper"):
        assert f"bilayer settings {model}\n" in listed
    assert main(["settings", "morley"]) == 0
    assert describe(MorleySettings) in capsys.readouterr().out
    assert "solver.profile = 'quadratic'" in describe(MorleySettings)
    assert max(map(len, describe(MorleySettings).splitlines())) <= 100
    assert main(["settings", "morly"]) == 2
    assert "did you mean 'morley'" in capsys.readouterr().err


def test_settings_as_json(capsys):
    listed = json_of(capsys, "settings", "hinge")
    assert {"name": "ramp", "default": 0.015}.items() <= listed["hinge"][6].items()


def test_a_result_as_json_is_in_si_units(result_file, capsys):
    told, result = json_of(capsys, "info", str(result_file)), open_result(result_file)
    assert (told["solver"], told["model"], told["specimen"]) == ("dshell", "paper", "paper")
    assert [row["prestretch"] for row in told["milestones"]] == [1.03, 1.06, 1.09]
    assert [row["height"] for row in told["milestones"]] == result["height"].values.tolist()
    assert told["milestones"][0]["energy"] == {"membrane": 1e-3, "bending": 2e-3}
    assert told["milestones"][0]["self_contact_gap"] is None  # infinite
    assert told["units"]["height"] == "m"
    assert "quality" not in told["units"]
    assert any("stable" in sentence for sentence in told["trust"])


def test_a_comparison_as_json(folder, capsys):
    write_result(cap_result(), folder / "a.nc")
    write_result(cap_result(small_specimen((1.03,)), solver="fenics"), folder / "b.nc")
    told = json_of(capsys, "compare", "a.nc", "b.nc")
    (row,) = told["milestones"]
    assert (told["first"], told["second"]) == ("dshell paper", "fenics paper")
    assert row["rms_distance"] == pytest.approx(0.0, abs=1e-12)
    assert row["first"]["height"] == row["second"]["height"] > 0


def test_a_fit_as_json(folder, capsys):
    stretches = [1.0, 1.1, 1.2, 1.3, 1.4, 1.5]
    rows = [f"{x},{40e3 * (x - x**-2)}" for x in stretches]  # neo-Hookean
    (folder / "t.csv").write_text("\n".join(["stretch,nominal stress (Pa)", *rows]))
    (told,) = json_of(capsys, "fit", "t.csv", "--law", "neo-hookean")
    assert told["law"] == "neo-hookean"
    assert told["shear_modulus"] == pytest.approx(40e3, rel=1e-6)
    assert all(isfinite(constant["value"]) for constant in told["constants"])


def test_states_as_json(folder, capsys):
    words = ["states", "dome.toml", "--mesh-size", "0.02", "--prestretch", "1.03", "--starts", "1"]
    told = json_of(capsys, *words, "--quiet")
    assert told["search"].startswith("1 state from 1 start")
    assert told["milestones"][0]["height"] > 0


def options_of(verb):
    (verbs,) = [a for a in _parser([verb])._actions if isinstance(a, argparse._SubParsersAction)]
    return verbs.choices[verb]._actions


@pytest.mark.parametrize("verb", VERBS)
def test_every_option_has_a_help_text(verb):
    without = [action.dest for action in options_of(verb) if not action.help]
    assert without == []


def completions(line):
    """Return what the shell is told for a line, as argcomplete's own protocol has it."""
    code = (
        "import os, sys\n"
        "os.dup2(1, 8)\n"
        "sys.argv[:] = ['bilayer']\n"
        "from bilayer.__main__ import main; main()"
    )
    asked = {"_ARGCOMPLETE": "1", "_ARGCOMPLETE_IFS": "\n", "COMP_LINE": line, "COMP_TYPE": "9",
             "COMP_POINT": str(len(line)), "_ARGCOMPLETE_SUPPRESS_SPACE": "1"}  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | asked, capture_output=True, text=True
    )
    return done.stdout.split()


def test_the_tab_key_completes_verbs_options_and_models():
    pytest.importorskip("argcomplete")
    assert completions("bilayer se") == ["settings"]
    assert completions("bilayer solve --res") == ["--resume"]
    assert completions("bilayer solve --model m") == ["morley"]
    assert completions("bilayer solve --solver b") == ["both"]


def test_a_completion_without_its_package_tells_nothing(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "argcomplete", None)
    monkeypatch.setenv("_ARGCOMPLETE", "1")
    monkeypatch.setenv("COMP_LINE", 'bilayer solve "my sp')
    monkeypatch.setenv("COMP_POINT", "20")
    assert main([]) == 1
    assert capsys.readouterr() == ("", "")


def test_a_flat_sheet_has_no_radius(folder, capsys):
    specimen = small_specimen((1.0000000001,))
    write_result(cap_result(specimen), folder / "flat.nc")
    assert main(["info", "flat.nc"]) == 0
    assert " flat " in capsys.readouterr().out


def test_a_mesh_that_is_too_coarse_is_said_under_the_table(folder, capsys):
    words = ["solve", "dome.toml", "--mesh-size", "0.03", "--prestretch", "1.15"]
    assert main([*words, "-o", "coarse.nc"]) == 0
    assert "The mesh is TOO COARSE FOR THE CURVATURE at 1.15" in capsys.readouterr().out
