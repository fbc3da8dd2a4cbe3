"""The folder that Sphinx works in: a copy of the pages, so that nothing is written beside them."""

import re
import shutil
from collections.abc import Mapping
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]
COPIED = ("docs", "examples")
LINKED = ("CHANGELOG.md", "LICENSE", "docker", "fenics_model", "results")
"""What the pages link beside themselves."""
MATHJAX = Path("/usr/share/javascript/mathjax")
MATHJAX_PARTS = (
    "MathJax.js",
    "config/TeX-AMS_CHTML.js",
    "extensions",
    "jax/element",
    "jax/input/TeX",
    "jax/output/CommonHTML",
    "fonts/HTML-CSS/TeX/woff",
)
"""Debian's MathJax, without the other ways to write and to show formulas."""
LINK_BY_FILE = re.compile(r"\[[\w/-]+\.md\]\((?=[\w./-]+\.md)")
"""A link with the name of a page; on the site it has the title of that page instead."""
GALLERY_LINK = re.compile(r"\]\(\.\./((?:\.\./)*)examples/gallery/([\w/-]+)\.(?:py|rst)\)")
"""A link to an example's script; on the site it leads to the page that the gallery makes of it."""


def stage(folder: Path, written: Mapping[str, str]) -> Path:
    """Lay pages and examples into an empty folder; return the one with `conf.py`.

    Parameters
    ----------
    folder : Path
        Made anew.
    written : mapping of str to str
        By what a page says where it wants a text, as `<!-- scripts/docs writes: NAME -->`: the
        text.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in COPIED:
        shutil.copytree(CHECKOUT / name, folder / name)
    for name in LINKED:
        (folder / name).symlink_to(CHECKOUT / name)
    for page in (folder / "docs").rglob("*.md"):
        page.write_text(_with_written(page.read_text(encoding="utf-8"), written), encoding="utf-8")
    return folder / "docs"


def _with_written(page: str, written: Mapping[str, str]) -> str:
    for name, text in written.items():
        page = page.replace(f"<!-- scripts/docs writes: {name} -->", text)
    page = GALLERY_LINK.sub(r"](\1gallery/\2.rst)", page).replace(
        "gallery/README.rst", "gallery/index.rst"
    )
    return LINK_BY_FILE.sub("[](", page)


def copy_mathjax(folder: Path) -> None:
    """Copy what the pages need of MathJax to a folder of its own."""
    for part in MATHJAX_PARTS:
        source, target = MATHJAX / part, folder / part
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, target, dirs_exist_ok=True)
        else:
            shutil.copy(source, target)
