"""The states of a search as a table, and how sure the search is of them."""

import numpy as np
import pandas as pd
import xarray as xr

from bilayer.landscape.catalogue import NOWHERE
from bilayer.landscape.dataset import ASKED, CHANCE
from bilayer.results.report import gap_words
from bilayer.results.schema import TIMES_FOUND
from bilayer.results.table import cells

FREELY = 1e-2
"""Least stiffness over the next one, below which a shape turns almost freely."""


def states_table(states: xr.Dataset) -> str:
    """Return a line per state, the lowest first, under two of titles and units."""
    energy = states["energy"].sum("term").values
    columns = {
        ("", "state"): [str(k) for k in range(len(energy))],
        ("energy", "mJ"): cells(1e3 * energy, "{:.5f}"),
        ("above", "%"): cells(100 * (energy / energy[0] - 1), "{:.3f}"),
        ("", "quality"): cells(states["quality"].values, "{:.3f}"),
        ("radius", "mm"): cells(1e3 * states["sphere_radius"].values, "{:#.5g}"),
        ("height", "mm"): cells(1e3 * states["height"].values, "{:.2f}"),
        ("", "symmetry"): symmetry_words(states),
        ("stiffness", "Pa/mm"): cells(1e-3 * states["least_stiffness"].values, "{:.3g}"),
        ("", "contact"): gap_words(states),
        ("", "found"): [str(count) for count in states[TIMES_FOUND].values],
    }
    if "confirmed" in states:
        columns |= _confirmation(states)
    return pd.DataFrame(columns).to_string(index=False)


def symmetry_words(states: xr.Dataset) -> list[str]:
    """Return the symmetry of each state in the plane of the sheet: C6v, C3, Cs (a mirror), C1."""
    turns, mirrored = states["symmetry_turns"].values, states["symmetry_mirrored"].values
    return [_group(int(n), bool(m)) for n, m in zip(turns, mirrored, strict=True)]


def _group(turns: int, mirrored: bool) -> str:
    if turns == 1:
        return "Cs" if mirrored else "C1"
    return f"C{turns}{'v' if mirrored else ''}"


def _confirmation(states: xr.Dataset) -> dict[tuple[str, str], list[str]]:
    return {
        ("FE", "stable"): ["yes" if found else "no" for found in states["confirmed"].values],
        ("FE energy", "mJ"): cells(1e3 * states["confirmed_energy"].values, "{:.5f}"),
        ("FE away", "% of R"): cells(100 * states["confirmed_distance"].values, "{:.2f}"),
    }


def describe_search(states: xr.Dataset) -> str:
    """Return in a few sentences how sure the search is of its states."""
    found, led = states[TIMES_FOUND].values, states["start_state"].values
    nowhere = int(np.count_nonzero(led == NOWHERE))
    once = int(np.count_nonzero(found == 1))
    sentences = [
        f"{_count(len(found), 'state')} from {_count(len(led), 'start')}, "
        f"{nowhere or 'none'} of which led nowhere.",
        f"{once or 'None'} of them found once: one more start finds another state with a chance "
        f"of {_chance(states)}.",
        *_free_turns(states),
        *_pairs_turned_over(states),
    ]
    if len(led) < states.attrs[ASKED]:
        sentences.append(f"STOPPED before {states.attrs[ASKED]} starts.")
    return " ".join(sentences)


def _chance(states: xr.Dataset) -> str:
    chance = states.attrs[CHANCE]
    return f"about {chance:.1%}" if chance else f"less than {1 / states.sizes['start']:.1%}"


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _free_turns(states: xr.Dataset) -> list[str]:
    ratio = states["least_stiffness"].values / states["next_stiffness"].values
    return [
        f"State {k} turns almost freely: its least stiffness is {ratio[k]:.0e} of the next one."
        for k in np.flatnonzero(ratio < FREELY)
    ]


def _pairs_turned_over(states: xr.Dataset) -> list[str]:
    others = states["turned_over"].values
    return [
        f"State {other} is state {k} turned over." for k, other in enumerate(others) if other > k
    ]
