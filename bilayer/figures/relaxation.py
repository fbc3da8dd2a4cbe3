"""A relaxation test and the Prony series that was fitted to it."""

import numpy as np
from matplotlib.figure import Figure

from bilayer.figures.style import RESULT_COLOURS, new_figure, print_style
from bilayer.fitting.relaxation import RelaxationFit


def draw_relaxation(fit: RelaxationFit) -> Figure:
    """Draw stress over the logarithm of time, measured and fitted, and the residuals below."""
    test = fit.test
    later = test.time > 0
    time = np.geomspace(test.time[later][0], test.time[-1], 301)
    rest = (fit.stress(test.time) - test.stress) / test.stress[0]
    with print_style():
        figure = new_figure(4.5, 4.5)
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        upper.semilogx(test.time[later], test.stress[later] / 1e3, "o", ms=4, mfc="none",
                       color="0.4", label="measured")  # fmt: skip
        label = f"{len(fit.series.terms)} terms, rms {100 * fit.rms:.2f} %"
        upper.plot(time, fit.stress(time) / 1e3, color=RESULT_COLOURS[0], label=label)
        for share, tau in fit.series.terms:
            upper.axvline(tau, color="0.85", lw=0.7, zorder=0)
            upper.annotate(f"{share:.2f}", (tau, 0.98), xycoords=("data", "axes fraction"),
                           ha="center", va="top", fontsize=7)  # fmt: skip
        upper.set(ylabel="stress (kPa)", ylim=(0, None))
        upper.legend(loc="lower left")
        lower.axhline(0, color="0.6", lw=0.7)
        lower.plot(test.time[later], 100 * rest[later], "o", ms=3, color=RESULT_COLOURS[0])
        lower.set(xlabel="time since the stretch was reached (s)", ylabel="residual (%)")
        return figure
