"""The jobs that scripts/reproduce starts beside the main one."""

import sys

import pytest
import reproduce_paper
from paper_studies import NAMES


@pytest.mark.parametrize(
    ("words", "started"),
    [
        ([], []),
        (["--all"], [(NAMES, ("dshell", "fenics"))]),
        (["--all", "--quick"], [(NAMES, ("dshell",))]),
    ],
)
def test_the_studies_come_with_all(words, started, tmp_path, monkeypatch):
    told = []
    monkeypatch.setattr(sys, "argv", ["reproduce", *words, "--output", str(tmp_path)])
    monkeypatch.setattr(reproduce_paper, "reproduce", lambda specimen, folder: None)
    monkeypatch.setattr(reproduce_paper, "run_studies", lambda *given: told.append(given))
    assert reproduce_paper.main() == 0
    assert told == started
