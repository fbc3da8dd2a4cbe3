"""A fit: measured stresses, and those of the laws with their constants."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from bilayer.figures.style import RESULT_COLOURS, RESULT_MARKERS, new_figure, print_style
from bilayer.fitting.fit import Fit, nominal_stress

LINES = ("-", "--", ":")
"""Another one when the colours begin anew."""


def draw_fits(fits: Sequence[Fit]) -> Figure:
    """Draw nominal stress over stretch, measured and of each law, and the residuals below.

    Parameters
    ----------
    fits : sequence of Fit
        Of the same measurements.

    Examples
    --------
    >>> import bilayer
    >>> import numpy as np
    >>> stretch = np.linspace(1.02, 1.5, 25)
    >>> stress = 100e3 * (stretch - stretch**-2.0)
    >>> test = bilayer.Measurement("exact", "uniaxial", stretch, stress)
    >>> fits = [bilayer.fit([test], law) for law in ("neo-hookean", "yeoh")]
    >>> len(bilayer.draw_fits(fits).axes)
    2
    """
    with print_style():
        figure = new_figure(4.5, 5.0)
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        for k, measurement in enumerate(fits[0].measurements):
            marker = RESULT_MARKERS[k % len(RESULT_MARKERS)]
            upper.plot(
                measurement.stretch,
                measurement.stress / 1e3,
                marker,
                ms=4,
                mfc="none",
                color="0.4",
                label=f"measured, {measurement.loading}",
            )
            stretch = np.linspace(measurement.stretch.min(), measurement.stretch.max(), 201)
            for j, fit in enumerate(fits):
                colour = RESULT_COLOURS[j % len(RESULT_COLOURS)]
                name = f"{fit.law_name}, rms {100 * fit.rms:.2f} %" if k == 0 else None
                stress = nominal_stress(fit.law, measurement.loading, stretch)
                line = LINES[j // len(RESULT_COLOURS) % len(LINES)]
                upper.plot(stretch, stress / 1e3, line, color=colour, label=name)
                own = nominal_stress(fit.law, measurement.loading, measurement.stretch)
                rest = (own - measurement.stress) / np.abs(measurement.stress).max()
                lower.plot(measurement.stretch, 100 * rest, marker, ms=3, color=colour)
        upper.set_ylabel("nominal stress (kPa)")
        upper.legend(handlelength=2.5)
        lower.axhline(0, color="0.6", lw=0.7)
        lower.set_xlabel("stretch")
        lower.set_ylabel("residual (%)")
        return figure
