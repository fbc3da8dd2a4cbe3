"""The README and the pages in docs: links lead somewhere, what they name is there, lines fit."""

import ast
import inspect
import re
from pathlib import Path

import pytest
from test_architecture import FLOORS

import bilayer

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]
WIDTH, WIDTH_OF_PRINTED_TABLES = 100, 120
README_WORDS = 900
PACKAGES = ("bilayer", "dshell", "fenics_model")
FOLDERS = (*PACKAGES, "scripts", "tests", "docs", "docker", "results")
MADE_LATER = ("results/quick",)  # by a command that the page describes

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


def prose(page: Path) -> str:
    """Return a page without its fenced blocks and without the tables that a benchmark wrote."""
    text = page.read_text(encoding="utf-8")
    text = re.sub(r"<!-- begin of .*?<!-- end of .*?-->", "", text, flags=re.DOTALL)
    return re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)


def headings(page: Path) -> set[str]:
    """Return the names by which the headings of a page can be linked."""
    found = re.findall(r"^#+ (.*)$", prose(page), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in found}


def names_in(file: Path) -> set[str]:
    """Return the names that a module defines, its classes' own ones with a dot."""
    found = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        found |= defined_by(node)
        if isinstance(node, ast.ClassDef):
            found |= {f"{node.name}.{name}" for part in node.body for name in defined_by(part)}
    return found


def defined_by(node: ast.stmt) -> set[str]:
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return {node.name}
    if isinstance(node, ast.Assign):
        return {target.id for target in node.targets if isinstance(target, ast.Name)}
    if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
        return {node.target.id}
    if isinstance(node, ast.ImportFrom | ast.If):
        inner = ast.walk(node)
        return {alias.name for part in inner if isinstance(part, ast.ImportFrom)
                for alias in part.names}  # fmt: skip
    return set()


def is_there(dotted: str) -> bool:
    """Whether a dotted name is a package, a module, or something that one of them defines."""
    words = dotted.split(".")
    for count in range(len(words), 0, -1):
        place = ROOT.joinpath(*words[:count])
        file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
        if file.exists():
            rest = ".".join(words[count:])
            return not rest or rest in names_in(file)
    return False


@each_page
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if target.startswith("http"):
            continue
        file, _, heading = target.partition("#")
        place = page.parent / file if file else page
        assert place.exists(), target
        assert not heading or heading in headings(place), target


@each_page
def test_named_files_exist(page):
    named = re.findall(rf"`((?:{'|'.join(FOLDERS)})/[^`\s]*)`", prose(page))
    for name in (name for name in named if not name.startswith(MADE_LATER)):
        assert list(ROOT.glob(name.rstrip("/"))), name


@each_page
def test_named_modules_exist(page):
    named = re.findall(rf"`((?:{'|'.join(PACKAGES)})(?:\.\w+)+)(?:\(.*?\))?`", prose(page))
    for name in named:
        assert is_there(name), name


@each_page
def test_lines_fit(page):
    for line in prose(page).splitlines():
        assert len(line) <= WIDTH or line.startswith(("|", "![")), line


@each_page
def test_printed_tables_fit(page):
    for line in page.read_text(encoding="utf-8").splitlines():
        assert len(line) <= WIDTH_OF_PRINTED_TABLES or line.startswith(("|", "![")), line


def test_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").split()) <= README_WORDS


@pytest.mark.parametrize("package", FLOORS)
def test_the_page_of_the_architecture_has_the_floors(package):
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = page.split(f"### `{package}`\n")[1].split("\n#")[0]
    rows = re.findall(r"^\| `(\w+)` \|", section, flags=re.MULTILINE)
    assert rows == [part for floor in reversed(FLOORS[package]) for part in reversed(floor)]


PUBLIC = [name for name in bilayer.__all__ if callable(getattr(bilayer, name))]


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_an_example(name):
    """In its docstring; `tests/bilayer/test_examples_of_docstrings.py` runs it."""
    text = inspect.getdoc(getattr(bilayer, name)) or ""
    assert ">>>" in text.partition("Examples\n--------\n")[2]


def test_every_public_name_is_on_the_page_of_the_reference():
    page = (ROOT / "docs" / "reference" / "python.md").read_text(encoding="utf-8")
    named = set(re.findall(r"^   (\w+)$", page, flags=re.MULTILINE))
    assert named - set(PUBLIC) == set()
    assert set(PUBLIC) - named == set(), "put it into docs/reference/python.md, by its topic"
