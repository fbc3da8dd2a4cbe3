"""`pip install .` in a plain virtual environment, without dolfinx."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from bilayer import (
    generate_mesh,
    paper_specimen,
    parse_specimen,
    read_planar_mesh,
    write_planar_mesh,
)
from bilayer.specimen.toml import template

CHECKOUT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Run a command of a virtual environment that holds this package and PyPI ones only."""
    home = tmp_path_factory.mktemp("plain")
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith("PYTHON")
    }
    environment["PATH"] = f"{home / 'venv/bin'}:/usr/bin:/bin"

    def run(folder, *words):
        return subprocess.run(
            words, cwd=folder, env=environment, capture_output=True, text=True, timeout=900
        )

    subprocess.run([sys.executable, "-m", "venv", home / "venv"], check=True)
    source = home / "source"
    names = ["pyproject.toml", "README.md", "LICENSE", "bilayer", "dshell", "fenics_model"]
    source.mkdir()
    subprocess.run(["cp", "-r", *[CHECKOUT / name for name in names], source], check=True)
    installed = run(home, "pip", "install", "--quiet", str(source))
    assert installed.returncode == 0, installed.stderr
    return run


@pytest.mark.network
@pytest.mark.slow
def test_the_shell_runs_and_its_result_is_read_and_drawn(plain, tmp_path):
    (tmp_path / "s.toml").write_text(template())
    specimen = parse_specimen(template(), ["mesh.size=0.012"])
    write_planar_mesh(generate_mesh(specimen), tmp_path / "m.vtk")
    words = ["--solver", "dshell", "--model", "paper", "--mesh", "m.vtk", "--prestretch", "1.03"]
    for verb in (
        ["solve", "s.toml", *words, "-o", "a.nc"],
        ["info", "a.nc"],
        ["plot", "a.nc", "-o", "a.png"],
        ["compare", "a.nc", "a.nc"],
    ):
        done = plain(tmp_path, "bilayer", *verb)
        assert done.returncode == 0, done.stderr


@pytest.mark.network
@pytest.mark.slow
def test_gmsh_works_or_says_what_it_needs(plain, tmp_path):
    """Its wheel wants system libraries that a machine may lack."""
    (tmp_path / "s.toml").write_text(template())
    done = plain(tmp_path, "bilayer", "mesh", "s.toml", "-o", "m.vtk")
    if done.returncode == 0:
        assert read_planar_mesh(tmp_path / "m.vtk").same_as(generate_mesh(paper_specimen()))
    else:
        assert (done.returncode, len(done.stderr.splitlines())) == (1, 1)
        assert "gmsh cannot be loaded" in done.stderr


@pytest.mark.network
@pytest.mark.slow
def test_the_finite_element_solver_says_what_it_needs(plain, tmp_path):
    (tmp_path / "s.toml").write_text(template())
    done = plain(tmp_path, "bilayer", "solve", "s.toml", "--solver", "fenics", "-o", "b.nc")
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    assert "dolfinx" in done.stderr
