"""What a fit says: constants, how well, over which range, and the table to paste."""

import math
from collections.abc import Sequence
from typing import Any

import tomli_w

from bilayer.fitting.fit import CONFIDENCE, Constant, Fit
from bilayer.specimen.materials import law_to_table
from bilayer.specimen.materials.stability import stability_limits


def fit_report(fit: Fit, without_bounds: Fit | None, name: str) -> str:
    """Return the lines of a fit, ending in a table [materials.NAME].

    Parameters
    ----------
    fit : Fit
        With bounds, or without.
    without_bounds : Fit or None
        The same without bounds, which says what they cost.
    name : str
        Of the material in a specimen file.
    """
    lines = [f"law = {fit.law_name}, mu = {fit.law.shear_modulus / 1e3:.4g} kPa"]
    lines += [f"  {_constant_line(constant)}" for constant in fit.constants]
    lines.append(quality_line(fit))
    for m in fit.measurements:
        span = f"stretch {m.stretch.min():.4g} to {m.stretch.max():.4g}"
        share = f", weight 1/{len(fit.measurements)}" if len(fit.measurements) > 1 else ""
        lines.append(f"of {m.name}: {m.loading}, {len(m.stretch)} points, {span}{share}")
    lines.append(_stability_line(fit))
    if without_bounds is not None:
        lines.append(_cost_line(fit, without_bounds))
    return "\n".join([*lines, "", materials_table(fit, name)])


def comparison_table(fits: Sequence[Fit]) -> str:
    """Return a line a law, the best by AICc first."""
    best = min(fit.aicc for fit in fits)
    lines = [f"{'law':14} {'constants':>9} {'rms %':>7} {'R2':>9} {'AICc':>8}  unstable from"]
    for fit in sorted(fits, key=lambda fit: fit.aicc):
        limit = min(stability_limits(fit.law).drucker.values())
        lines.append(
            f"{fit.law_name:14} {len(fit.constants):9d} {100 * fit.rms:7.3f} {fit.r_squared:9.6f} "
            f"{fit.aicc - best:8.1f}  {f'{limit:.3f}' if math.isfinite(limit) else '-'}"
        )
    return "\n".join(lines)


def fit_record(fit: Fit) -> dict[str, Any]:
    """Return a fit as a record of numbers in SI units."""
    limits = stability_limits(fit.law)
    return {
        "law": fit.law_name,
        "constants": [
            {
                "name": constant.name,
                "unit": constant.unit,
                "value": float(constant.value),
                "interval": [float(end) for end in constant.interval],
            }
            for constant in fit.constants
        ],
        "shear_modulus": float(fit.law.shear_modulus),
        "rms": float(fit.rms),
        "r_squared": float(fit.r_squared),
        "aicc": float(fit.aicc),
        "unstable_from": {loading: float(end) for loading, end in limits.drucker.items()},
        "bifurcates_from": float(limits.equal_loads),
        "table": law_to_table(fit.law),
    }


def quality_line(fit: Fit) -> str:
    """Return how well a law fits."""
    return (
        f"rms {100 * fit.rms:.3g} % of the largest stress, R2 = {fit.r_squared:.6f}, "
        f"AICc = {fit.aicc:.1f}"
    )


def materials_table(fit: Fit, name: str) -> str:
    """Return the table [materials.NAME] of a specimen file."""
    return tomli_w.dumps({"materials": {name: law_to_table(fit.law)}}).strip()


def _constant_line(constant: Constant) -> str:
    scale, unit = (1e-3, " kPa") if constant.unit == "Pa" else (1.0, "")
    low, high = (scale * end for end in constant.interval)
    interval = (
        f"{100 * CONFIDENCE:g} %: {low:.5g} to {high:.5g}" if math.isfinite(low) else "at its bound"
    )
    return f"{constant.name:9} {scale * constant.value:12.5g}{unit}  ({interval})"


def _stability_line(fit: Fit) -> str:
    limits = stability_limits(fit.law)
    found = [
        f"{loading} from {stretch:.4g} on"
        for loading, stretch in limits.drucker.items()
        if math.isfinite(stretch)
    ]
    text = "stable by Drucker's criterion" + (
        f" but {', '.join(found)}" if found else " to a stretch of 10"
    )
    if math.isfinite(limits.equal_loads):
        text += f"; under equal loads it bifurcates from {limits.equal_loads:.4g} on"
    return text


def _cost_line(fit: Fit, free: Fit) -> str:
    if math.isclose(fit.rms, free.rms, rel_tol=1e-6):
        return "the bounds of the constants cost nothing"
    values = ", ".join(
        f"{c.name} = {c.value * (1e-3 if c.unit == 'Pa' else 1):.4g}"
        + (" kPa" if c.unit == "Pa" else "")
        for c in free.constants
    )
    limit = min(stability_limits(free.law).drucker.values())
    until = f", unstable from {limit:.4g} on" if math.isfinite(limit) else ""
    return (
        f"the bounds of the constants cost {100 * (fit.rms - free.rms):.3g} %: without them "
        f"rms {100 * free.rms:.3g} %, {values}{until}"
    )
