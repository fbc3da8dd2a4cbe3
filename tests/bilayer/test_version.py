"""The provenance in a result: the commit and the versions."""

import shutil
import subprocess
import sys
from pathlib import Path

import gmsh
import numpy as np
import pytest

from bilayer.runtime.version import git_commit, own_versions

MODULE = Path(__file__).parents[2] / "bilayer" / "runtime" / "version.py"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """The module alone, in a checkout of its own."""
    (tmp_path / "bilayer" / "runtime").mkdir(parents=True)
    shutil.copy(MODULE, tmp_path / "bilayer" / "runtime")
    return tmp_path / "bilayer"


def commit_of(package: Path) -> str:
    code = f"import runpy; print(runpy.run_path('{package}/runtime/version.py')['git_commit']())"
    command = [sys.executable, "-c", code]
    return subprocess.run(
        command, cwd=package, capture_output=True, text=True, check=True
    ).stdout.strip()


def make_repository(folder: Path) -> str:
    git = ["git", "-C", str(folder), "-c", "user.name=a", "-c", "user.email=a@b"]
    subprocess.run([*git, "init", "--quiet"], check=True)
    subprocess.run([*git, "add", "."], check=True)
    subprocess.run([*git, "commit", "--quiet", "--message", "all"], check=True)
    command = [*git, "describe", "--always", "--dirty"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def test_commit_of_a_checkout_and_whether_it_was_edited(package):
    made = package.parent / "results" / "report.txt"
    made.parent.mkdir()
    made.touch()
    commit = make_repository(package.parent)
    assert len(commit) >= 7
    assert commit_of(package) == commit
    made.write_text("what was made does not make anything")
    assert commit_of(package) == commit
    with (package / "runtime" / "version.py").open("a") as module:
        module.write("# edited\n")
    assert commit_of(package) == f"{commit}-dirty"


@pytest.mark.parametrize("variable", ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE"])
def test_variables_of_git_do_not_lead_to_another_repository(
    package, tmp_path_factory, monkeypatch, variable
):
    other = tmp_path_factory.mktemp("other")
    (other / "file").write_text("of somebody else")
    make_repository(other)
    commit = make_repository(package.parent)
    places = {"GIT_DIR": ".git", "GIT_WORK_TREE": ".", "GIT_INDEX_FILE": ".git/index"}
    monkeypatch.setenv(variable, str(other / places[variable]))
    assert commit_of(package) == commit


def test_an_installed_package_has_the_commit_that_it_was_told(package):
    assert commit_of(package) == ""
    (package / "COMMIT").write_text("3bc4fe7\n")
    assert commit_of(package) == "3bc4fe7"


def test_another_projects_repository_is_not_taken(package):
    installed = package.parent / "site-packages" / "bilayer"
    shutil.copytree(package, installed)
    make_repository(package.parent)
    assert commit_of(installed) == ""


def test_versions_of_what_computes():
    versions = own_versions()
    assert versions["numpy"] == np.__version__
    assert versions["gmsh"].startswith(gmsh.__version__)
    assert versions["python"] == ".".join(map(str, sys.version_info[:3]))
    assert set(git_commit()) <= set("0123456789abcdefghijklmnopqrstuvwxyz-.")
