"""What a release says of itself in several places is the same in all of them."""

import json
import re
import tomllib
from pathlib import Path

import pytest

from bilayer import __version__

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CONDA_NAMES = {"gmsh": "python-gmsh", "matplotlib": "matplotlib-base", "dask": "dask-core"}


def yaml_of(path):
    yaml = pytest.importorskip("yaml")
    return yaml.safe_load((ROOT / path).read_text(encoding="utf-8"))


def test_the_version_is_one():
    assert json.loads((ROOT / "codemeta.json").read_text())["version"] == __version__
    assert str(yaml_of("CITATION.cff")["version"]) == __version__
    assert yaml_of("docker/conda/recipe.yaml")["context"]["version"] == __version__


def test_the_changelog_has_the_release_and_its_date():
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    version, date = re.findall(r"^## \[([\d.]+)\] - ([\d-]+)$", changes, flags=re.MULTILINE)[0]
    assert version == __version__
    assert date == str(yaml_of("CITATION.cff")["date-released"])


def test_the_citation_is_complete():
    citation = yaml_of("CITATION.cff")
    assert citation["cff-version"] == "1.2.0"
    assert {"message", "title", "authors", "version", "date-released", "license"} <= set(citation)
    assert citation["authors"] == [{"name": PROJECT["authors"][0]["name"]}]
    assert citation["license"] == PROJECT["license"]["text"]
    codemeta = json.loads((ROOT / "codemeta.json").read_text())
    assert codemeta["description"] == PROJECT["description"]
    assert codemeta["keywords"] == PROJECT["keywords"]
    assert codemeta["dateModified"] == str(citation["date-released"])
    page = (ROOT / "docs/help.md").read_text(encoding="utf-8")
    assert f"version = {{{__version__}}}" in page
    assert f"title   = {{{citation['title']}}}" in page


def test_the_recipe_needs_what_the_package_needs():
    needed = dict(
        re.fullmatch(r"([\w-]+)>=(.+)", each).groups() for each in PROJECT["dependencies"]
    )
    expected = {f"{CONDA_NAMES.get(name, name.lower())} >={v}" for name, v in needed.items()}
    asked = set(yaml_of("docker/conda/recipe.yaml")["requirements"]["run"])
    assert asked == expected | {f"python {PROJECT['requires-python']}"}


def test_all_extras_are_in_all():
    extras = PROJECT["optional-dependencies"]
    (everything,) = extras["all"]
    named = set(re.fullmatch(r"bilayer-shells\[(.*)\]", everything)[1].split(","))
    assert named == set(extras) - {"all", "test"}


@pytest.mark.parametrize("path", sorted((ROOT / ".github/ISSUE_TEMPLATE").glob("*.yml")))
def test_the_forms_for_issues_are_whole(path):
    form = yaml_of(path)
    if path.name != "config.yml":
        assert {"name", "description", "body"} <= set(form)
        assert all({"type", "attributes"} <= set(field) for field in form["body"])


def test_the_paper_cites_what_its_bibliography_has():
    bibliography = (ROOT / "paper/paper.bib").read_text(encoding="utf-8")
    entries = re.findall(r"^@\w+\{(\w+),", bibliography, flags=re.MULTILINE)
    text = (ROOT / "paper/paper.md").read_text(encoding="utf-8")
    cited = set(re.findall(r"@(\w+)", text.split("---", 2)[2]))
    assert cited == set(entries)
    assert len(entries) == len(set(entries))
    for picture in re.findall(r"\]\((\.\./[^)]+)\)", text):
        assert (ROOT / "paper" / picture).resolve().is_file()
    assert 250 < len(text.split()) < 1500
