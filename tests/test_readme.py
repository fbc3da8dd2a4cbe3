"""The Python scripts of the README and of the page on usage do what they say."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from bilayer.specimen.toml import template

README = Path(__file__).parents[1] / "README.md"
USAGE = README.parent / "docs" / "usage.md"


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


@pytest.mark.slow
def test_the_python_scripts_of_the_page_on_usage(tmp_path):
    scripts = re.findall(r"```python\n(.*?)```", USAGE.read_text(), flags=re.DOTALL)
    (tmp_path / "specimen.toml").write_text(template())
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(scripts)], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "shell.nc").stat().st_size > 1000
    heights = re.findall(r"^\((1\.\d+), \1\) ([\d.]+)$", done.stdout, flags=re.MULTILINE)
    assert [stretch for stretch, _ in heights] == ["1.03", "1.06", "1.03"]
    assert float(heights[0][1]) == pytest.approx(float(heights[2][1]), rel=1e-6)


def test_every_file_that_the_readme_links_is_there():
    for target in re.findall(r"\]\(([^)#:]+)\)", README.read_text()):
        assert (README.parent / target).exists(), target
