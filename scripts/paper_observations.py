"""The paper's observations (sections V to VII), compared with the numbers of two results."""

import numpy as np
import xarray as xr

from bilayer.geometry.alignment import rms_distance
from bilayer.mesh.planar import flat_surface
from bilayer.results.comparison import compare
from bilayer.results.schema import result_mesh

PAPER_FIRST_QUALITY = 0.8
"""At 1.03, read off its figure 6 (section VII)."""
PAPER_LAG = 0.08
"""Difference of the shell's quality from that of the finite elements (section VII)."""
PAPER_LIMIT = 1.24
"""Beyond which it failed to converge (section V)."""


def observations(fenics: xr.Dataset, shell: xr.Dataset) -> list[str]:
    """Return a line for each of the paper's observations, then two on what the results show."""
    found = [
        _same_shape(shell),
        _failure(shell),
        _first_quality(fenics, shell),
        _lag(fenics, shell),
    ]
    lines = [f"- The paper: {said}. Here: {seen}" for said, seen in found]
    return [*lines, _shell_conclusion(fenics, shell), _fenics_conclusion(fenics)]


def _same_shape(shell: xr.Dataset) -> tuple[str, str]:
    """Compare the shapes of the shell, scaled to one size, with that of the middle prestretch."""
    prestretch = shell["prestretch"].values
    middle = int(np.argmin(np.abs(prestretch - 1.15)))
    apart = {
        float(value): _difference_of_shape(shell, k, middle)
        for k, value in enumerate(prestretch)
        if k != middle
    }
    first = float(prestretch[0])
    others = [value for value in apart if value != first]
    alike = [value for value in others if apart[value] < apart[first] / 2]
    listed = ", ".join(
        f"{100 * difference:.0f} % at {value:g}" for value, difference in apart.items()
    )
    verdict = (
        "reproduced" if len(alike) == len(others) else f"{len(alike)} of {len(others)} are alike"
    )
    return (
        f"all prestretches but {first:g} give the same shape",
        f"{verdict}; scaled to one size, the shell's shapes differ from that at "
        f"{prestretch[middle]:g} by {listed} (rms, of their size; alike: less than half of the "
        "first).",
    )


def _failure(shell: xr.Dataset) -> tuple[str, str]:
    said = f"cut short at {PAPER_LIMIT}, no convergence beyond"
    if bool(shell["converged"].all()):
        return (
            said,
            "not reproduced with the default settings; the shell's run ends at every prestretch up "
            f"to {float(shell['prestretch'].max()):g} (docs/shell-measurements.md has the time "
            "steps with which it stops).",
        )
    return said, f"the shell's run stopped: {shell.attrs['stop_reason']}."


def _first_quality(fenics: xr.Dataset, shell: xr.Dataset) -> tuple[str, str]:
    found = [float(result["quality"][0]) for result in (shell, fenics)]
    return (
        f"quality about {PAPER_FIRST_QUALITY} at {float(shell['prestretch'][0]):g}",
        f"{found[0]:.2f} for the shell and {found[1]:.2f} for the finite elements, "
        "by our reading of its measure.",
    )


def _lag(fenics: xr.Dataset, shell: xr.Dataset) -> tuple[str, str]:
    behind = (fenics["quality"] - shell["quality"]).dropna("prestretch")
    small = behind.sel(prestretch=slice(None, 1.1))
    return (
        f"the shell's quality is about {PAPER_LAG} behind that of the finite elements",
        f"{float(small.mean()):.2f} lower up to 1.1, and from {float(behind.min()):.2f} to "
        f"{float(behind.max()):.2f} lower over all.",
    )


def _shell_conclusion(fenics: xr.Dataset, shell: xr.Dataset) -> str:
    distance = 100 * compare(fenics, shell)["rms_distance_over_radius"].dropna("prestretch")
    first, last = (float(value) for value in distance["prestretch"].values[[0, -1]])
    bent = float((fenics["sphere_radius"] / shell["sphere_radius"]).sel(prestretch=first))
    return (
        f"The printed shell overdoes the stretch: at {first:g} its sphere is {bent:.1f} times as "
        f"curved as that of the finite elements, and it lies {float(distance[0]):.1f} % of the "
        f"disc's radius away from them, {float(distance[-1]):.1f} % at {last:g}."
    )


def _fenics_conclusion(fenics: xr.Dataset) -> str:
    reached = fenics.isel(prestretch=fenics["converged"].values == 1)
    if reached.sizes["prestretch"] == 0:
        return "The finite-element model reached no prestretch."
    best = reached.isel(prestretch=int(np.argmin(reached["quality"].values)))
    stable = int((reached["unstable_modes"] == 0).sum())
    return (
        f"The finite-element model reaches {reached.sizes['prestretch']} of "
        f"{fenics.sizes['prestretch']} prestretches, {stable} of them as stable shapes; it comes "
        f"nearest to a hemisphere at {float(best['prestretch']):g}, with a quality of "
        f"{float(best['quality']):.2f}, and never gets there."
    )


def accurate_shell_conclusion(fenics: xr.Dataset, shell: xr.Dataset) -> str:
    """Return in one sentence how near the accurate shell comes to the finite elements."""
    distance = 100 * compare(fenics, shell)["rms_distance_over_radius"].dropna("prestretch")
    listed = ", ".join(f"{float(value):.2f} % at {float(value.prestretch):g}" for value in distance)
    return (
        "The accurate shell, in "
        f"{float(shell['wall_time'].sum() / fenics['wall_time'].sum()):.0%} of the time, lies "
        f"this near to the finite elements (rms distance over the disc's radius): {listed}."
    )


def _difference_of_shape(result: xr.Dataset, k: int, other: int) -> float:
    """Rms distance of two milestones, each scaled to an rms size of 1."""
    weights = flat_surface(result_mesh(result)).node_areas
    shapes = []
    for index in (k, other):
        centred = _last_shape(result, index)
        centred = centred - np.average(centred, axis=0, weights=weights)
        size = np.sqrt(np.average((centred**2).sum(axis=1), weights=weights))
        shapes.append(centred / size)
    return rms_distance(shapes[0], shapes[1], weights)


def _last_shape(result: xr.Dataset, k: int) -> np.ndarray:
    """Return the shape at a milestone, or the last one on the way to it."""
    name = "position" if result["converged"][k] else "last_position"
    return result[name].isel(prestretch=k).values
