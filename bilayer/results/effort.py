"""The effort of a result as text: its start, its iterations, the parts of its CPU time."""

import numpy as np
import xarray as xr

from bilayer.results.table import stretch_text, stretches

_TIME_VARIABLES = ("assembly_time", "factorisation_time", "cpu_time")
_RARE = {
    "stabilised_steps": ("stabilised", "pseudo-time steps"),
    "escapes": ("escaped", "unstable equilibria left"),
}
"""Counts that are listed if they are not zero, each with a title and a unit."""


def effort_lines(result: xr.Dataset) -> list[str]:
    """Return lines on the effort, each with a title, as far as a result holds it."""
    lines = []
    if "start" in result.attrs:
        lines.append(f"start       {result.attrs['start']}")
    if all(name in result for name in _TIME_VARIABLES):
        lines.append(f"effort      {_effort(result)}")
    return lines + _rare_lines(result)


def _effort(result: xr.Dataset) -> str:
    assembly, factorisation, total = (float(result[name].sum()) for name in _TIME_VARIABLES)
    rest = total - assembly - factorisation
    return (
        f"{int(result['iterations'].sum())} Newton iterations, "
        f"{int(result['factorisations'].sum())} factorisations; {total:.1f} s of CPU: "
        f"assembly {assembly:.1f}, factorisation {factorisation:.1f}, rest {rest:.1f}"
    )


def _rare_lines(result: xr.Dataset) -> list[str]:
    """Return a line for each rare event of a run: 'stabilised  9 pseudo-time steps at 1.03'."""
    lines = []
    for name, (title, unit) in _RARE.items():
        counts = result[name].values if name in result else np.zeros(0)
        at = [
            f"{count} {unit} at {stretch_text(stretches(result)[milestone])}"
            for milestone, count in enumerate(counts)
            if count
        ]
        if at:
            lines.append(f"{title:<12}{', '.join(at)}")
    return lines
