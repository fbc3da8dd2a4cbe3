"""Links of finished pages: each leads to a file of the site, and to a place in it."""

from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class _Page(HTMLParser):
    """The links of a page, the places that can be linked, and what it loads from elsewhere."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.loaded: set[str] = set()
        self.places: set[str] = set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value for name, value in attrs if value is not None}
        self.places |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.add(given["href"])
        elif tag == "link" and given.get("rel") in ("stylesheet", "preload", "icon"):
            self.loaded.add(given["href"])
        elif tag in ("img", "script", "source", "iframe") and "src" in given:
            self.loaded.add(given["src"])


_page = cache(_Page)


def faults(site: Path) -> Iterator[str]:
    """Yield what is wrong with the links of a site, page by page."""
    for file in sorted(set(site.rglob("*.html")) - set((site / "_static").rglob("*.html"))):
        page = _page(file)
        for target in sorted(page.links | page.loaded):
            fault = _fault(file, target, loaded=target in page.loaded)
            if fault:
                yield f"{file.relative_to(site)}: {target}: {fault}"


def _fault(file: Path, target: str, loaded: bool) -> str:
    parts = urlsplit(target)
    if parts.scheme or parts.netloc:
        return "is loaded over the network" if loaded and parts.scheme != "data" else ""
    place = (file.parent / unquote(parts.path)).resolve() if parts.path else file
    if place.is_dir():
        place /= "index.html"
    if not place.is_file():
        return "is not there"
    if parts.fragment and place.suffix == ".html":
        there = _page(place).places
        return "" if unquote(parts.fragment) in there else "has no such place"
    return ""
