"""What a result took, in a few lines: its start, its iterations, where the time went."""

import numpy as np
import xarray as xr

from bilayer.results.table import stretch_text, stretches

_SECONDS = ("assembly_time", "factorisation_time", "cpu_time")
_SELDOM = {
    "stabilised_steps": "time steps of the viscous flow",
    "escapes": "unstable equilibria left",
}


def effort_lines(result: xr.Dataset) -> list[str]:
    """Return lines on the effort, each with a title, as far as a result holds it."""
    lines = []
    if "start" in result.attrs:
        lines.append(f"start       {result.attrs['start']}")
    if all(name in result for name in _SECONDS):
        lines.append(f"effort      {_effort(result)}")
    return lines + [
        f"{'' if number else 'seldom':<12}{line}" for number, line in enumerate(_seldom(result))
    ]


def _effort(result: xr.Dataset) -> str:
    assembly, factorisation, total = (float(result[name].sum()) for name in _SECONDS)
    rest = total - assembly - factorisation
    return (
        f"{int(result['iterations'].sum())} Newton iterations, "
        f"{int(result['factorisations'].sum())} factorisations; {total:.1f} s of CPU: "
        f"assembly {assembly:.1f}, factorisation {factorisation:.1f}, rest {rest:.1f}"
    )


def _seldom(result: xr.Dataset) -> list[str]:
    """Return what should not be passed over where it has happened."""
    found = []
    for name, words in _SELDOM.items():
        counts = result[name].values if name in result else np.zeros(0)
        if counts.any():
            at = [
                f"{count} at {stretch_text(stretches(result)[milestone])}"
                for milestone, count in enumerate(counts)
                if count
            ]
            found.append(f"{words}: {', '.join(at)}")
    return found
