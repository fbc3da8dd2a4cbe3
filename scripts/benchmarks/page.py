"""A page of prose in which each benchmark keeps the tables of its last run."""

from collections.abc import Mapping, Sequence

import pandas as pd

from bilayer.errors import InputError


def table_text(rows: Sequence[Mapping[str, str]]) -> str:
    """Return rows as a table whose titles stand a word a line, so that it fits a page."""
    frame = pd.DataFrame(rows)
    titles = [title.split() for title in frame.columns]
    height = max(map(len, titles))
    lines = [(*[""] * (height - len(words)), *words) for words in titles]
    frame.columns = pd.MultiIndex.from_tuples(lines)
    return frame.to_string(index=False)


def with_part(page: str, name: str, texts: Sequence[str]) -> str:
    """Return a page whose part of that name holds these texts, as they were printed."""
    begin, end = (f"<!-- {edge} of scripts/benchmark {name} -->" for edge in ("begin", "end"))
    if begin not in page or end not in page:
        raise InputError(f"page: no lines {begin!r} and {end!r} to write between")
    before, after = page[: page.index(begin)], page[page.index(end) :]
    blocks = "\n\n".join(f"```\n{text}\n```" for text in texts)
    return f"{before}{begin}\n\n{blocks}\n\n{after}"
