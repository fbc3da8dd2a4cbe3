"""The README's Python script does what it says."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from bilayer.specimen.toml import template

README = Path(__file__).parents[1] / "README.md"


@pytest.mark.slow
def test_the_python_script_of_the_readme(tmp_path):
    scripts = re.findall(r"```python\n(.*?)```", README.read_text(), flags=re.DOTALL)
    assert len(scripts) == 1
    (tmp_path / "specimen.toml").write_text(template())  # as `bilayer init` has made it before
    done = subprocess.run(
        [sys.executable, "-c", scripts[0]], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    for name in re.findall(r'"([\w.]+\.(?:nc|png))"', scripts[0]):
        assert (tmp_path / name).stat().st_size > 1000, name


def test_every_file_that_the_readme_links_is_there():
    for target in re.findall(r"\]\(([^)#:]+)\)", README.read_text()):
        assert (README.parent / target).exists(), target
