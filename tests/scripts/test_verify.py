"""The ladder's table and exit status: a miss is shown and fails, whatever its cause."""

import math
from pathlib import Path

import pytest

pytest.importorskip("dolfinx")

import verify_ladder
from verification.rung import MISSED, PASSED, REPORTED, Check, Rung

from bilayer.errors import ComputationError

PAGE = Path(__file__).parents[2] / "docs" / "verification.md"


def made_rung(*checks):
    return Rung(99, "made", "A made case", "made here", lambda: iter(checks))


def broken():
    yield Check("the first number", 1.0, 1.0, 0.1)
    raise ComputationError("it diverged")


@pytest.mark.parametrize(
    ("check", "verdict"),
    [
        (Check("within", 101.0, 100.0, 0.02), PASSED),
        (Check("beyond", 103.0, 100.0, 0.02), MISSED),
        (Check("below a negative one", -0.97, -1.0, 0.02), MISSED),
        (Check("absolute", 0.03, 0.0, 0.02, 1.0), MISSED),
        (Check("not a number", math.nan, 1.0, 0.02), MISSED),
        (Check("not judged", 2.0, 1.0), REPORTED),
    ],
    ids=lambda value: getattr(value, "quantity", value),
)
def test_verdict(check, verdict):
    assert check.verdict == verdict


def test_a_ladder_without_a_miss_passes_and_is_written(tmp_path, capsys):
    output = tmp_path / "page.md"
    assert verify_ladder.verify([made_rung(Check("a number", 1.01, 1.0, 0.02))], output) == 0
    row = "| a number | 1.01 | 1 | 1.000 % | 2 % | passed |"
    assert row in output.read_text()
    assert "1 passed, 0 missed" in capsys.readouterr().out


def test_a_miss_is_shown_and_fails(tmp_path, capsys):
    output = tmp_path / "page.md"
    assert verify_ladder.verify([made_rung(Check("a number", 1.03, 1.0, 0.02))], output) == 1
    assert "| a number | 1.03 | 1 | 3.000 % | 2 % | missed |" in output.read_text()
    assert "0 passed, 1 missed" in capsys.readouterr().out


def test_a_case_that_cannot_be_computed_is_a_miss_with_its_reason(tmp_path, capsys):
    output = tmp_path / "page.md"
    rung = Rung(99, "made", "A made case", "made here", broken)
    assert verify_ladder.verify([rung], output) == 1
    assert "it diverged" in output.read_text()
    assert "1 passed, 1 missed" in capsys.readouterr().out


def test_chosen_rungs_are_printed_and_the_page_stays(tmp_path, capsys):
    output = tmp_path / "page.md"
    assert verify_ladder.main(["9", "--output", str(output)]) == 0
    assert "Lattice of hinges" in capsys.readouterr().out
    assert not output.exists()


def test_a_rung_can_be_renewed_in_its_place_on_the_page(tmp_path, capsys):
    output, text = tmp_path / "page.md", PAGE.read_text()
    old = text.replace("| passed |", "| missed |", 1)
    assert old.index("| missed |") < old.index("## 4. ")  # of rung 1
    output.write_text(old.replace("## 9. Lattice of hinges (dshell hinge)", "## 9. Another"))
    assert verify_ladder.main(["9", "--renew", "--output", str(output)]) == 0
    found = output.read_text()
    titles = [line for line in text.splitlines() if line.startswith("## ")]
    assert [line for line in found.splitlines() if line.startswith("## ")] == titles
    assert " 1 missed.\n" in found and found.count("| missed |") == 1
    whole = text.replace(" 0 missed.", " 1 missed.").splitlines()
    assert len(found.splitlines()) == len(whole)
    output.write_text("# Verification\n")
    assert verify_ladder.main(["9", "--renew", "--output", str(output)]) == 2
    assert "rung 1: is not on the page" in capsys.readouterr().err


def test_a_rung_that_does_not_exist_is_refused(capsys):
    assert verify_ladder.main(["99"]) == 2
    assert "rung 99: expected one of 1, " in capsys.readouterr().err


def test_help_shows_an_example(capsys):
    with pytest.raises(SystemExit) as end:
        verify_ladder.main(["--help"])
    assert end.value.code == 0
    assert "scripts/verify 9 13" in capsys.readouterr().out


def test_the_page_in_the_docs_is_of_this_ladder_and_missed_nothing():
    text = PAGE.read_text()
    titles = [f"## {rung.number}. {rung.title} ({rung.solver})" for rung in verify_ladder.RUNGS]
    assert [line for line in text.splitlines() if line.startswith("## ")][:-1] == titles
    assert "| missed |" not in text
