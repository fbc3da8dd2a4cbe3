"""A scan laid onto a shape: where it is away, and how far, from above and as a histogram."""

import numpy as np
from matplotlib.figure import Figure

from bilayer.figures.style import new_figure, print_style
from bilayer.results.released_shapes import MM_PER_M
from bilayer.scan.cloud import Cloud
from bilayer.scan.comparison import ScanMatch
from bilayer.scan.profile import Profile, ProfileMatch

SHOWN = 20_000
"""Points drawn."""


def draw_scan(scan: Cloud, match: ScanMatch) -> Figure:
    """Draw the scan's points from above, coloured by their distance, and how often which occurs.

    Parameters
    ----------
    scan : Cloud
        All of its points are drawn, or many.
    match : ScanMatch
        Of the milestone that is drawn, made with all points of the scan.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> scan = bilayer.Cloud("itself", result["position"].values[0])
    >>> (best,) = bilayer.compare_scan(result, scan)
    >>> bilayer.draw_scan(scan, best).axes[0].get_xlabel()
    'x (mm)'
    """
    counted = np.flatnonzero(~match.outliers)
    shown = counted[:: max(1, len(counted) // SHOWN)]
    points = MM_PER_M * match.motion.moved(scan.points[shown])
    distance = MM_PER_M * match.distances
    largest = float(np.abs(distance[counted]).max()) or 1.0
    order = np.argsort(points[:, 2])
    with print_style():
        figure = new_figure(7.0, 3.4)
        above, beside = figure.subplots(1, 2, width_ratios=(1.4, 1))
        drawn = above.scatter(
            *points[order, :2].T, c=distance[shown][order], s=1.5, cmap="coolwarm",
            vmin=-largest, vmax=largest, rasterized=True,
        )  # fmt: skip
        above.set(aspect="equal", xlabel="x (mm)", ylabel="y (mm)", title=match.title)
        figure.colorbar(drawn, ax=above, label="distance (mm), above the shape positive")
        beside.hist(distance[counted], bins=60, color="0.5")
        beside.set(xlabel="distance (mm)", ylabel="points")
        beside.set_title(f"rms {MM_PER_M * match.rms:.3f} mm")
        return figure


def draw_profile(profile: Profile, match: ProfileMatch) -> Figure:
    """Draw a profile laid onto the edge of a shape, as seen from the side.

    Parameters
    ----------
    profile : Profile
        From a photograph.
    match : ProfileMatch
        Of the milestone that is drawn.
    """
    edge = MM_PER_M * match.edge
    points = MM_PER_M * (profile.points + match.shift)
    with print_style():
        figure = new_figure(5.0, 3.4)
        axes = figure.subplots()
        axes.plot(*edge.T, color="0.4", label=match.title)
        axes.plot(*points.T, ".", markersize=3, color="tab:red", label=profile.name)
        axes.set(aspect="equal", xlabel="to the right (mm)", ylabel="up (mm)")
        axes.set_title(f"rms {MM_PER_M * match.rms:.3f} mm")
        axes.legend(frameon=False)
        return figure
