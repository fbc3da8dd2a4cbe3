"""Two hundred of the campaign's inputs, and the page that has its figures."""

import subprocess
import sys
from pathlib import Path

import pytest

from attack.page import TABLES, with_part

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_two_hundred_inputs_are_handled():
    command = [sys.executable, ROOT / "scripts" / "run_attack.py", "inputs", "--quick"]
    done = subprocess.run([*command, "--count", "200"], capture_output=True, text=True, timeout=600)
    assert done.stdout.splitlines()[-1] == "0 of 200 mishandled", done.stdout + done.stderr


def test_the_page_has_a_place_for_each_table():
    page = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8")
    for name in TABLES:
        assert "| a |" in with_part(page, name, "| a |")
