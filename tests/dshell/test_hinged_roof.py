"""A shallow roof under a force, past its limit points, by arc length; `scripts/verify 17`."""

import numpy as np
import pytest
from verification import hinged_roof
from verification.arc_length import Scales, follow_arc
from verification.shell_roof import ShellRoof, shell_curve

from bilayer.errors import ComputationError


def test_the_natural_curvature_is_that_of_the_roof():
    """At rest it lies on the cylinder, and a force of no size does not move it."""
    roof = ShellRoof(hinged_roof.THICK, 8)
    (first, *_) = follow_arc(
        roof, roof.start, Scales(1.0, 1e-3, 1e-7), 1e-3, lambda deflection, force: force <= 0
    )
    assert first.force == pytest.approx(1e-6, abs=1e-5)
    assert abs(first.deflection) < 0.02 * hinged_roof.THICK


def test_force_and_deflection_of_a_thin_roof_both_turn_back():
    curve = hinged_roof.Curve(shell_curve(hinged_roof.THIN, 12, step=0.1))
    limits, returns = curve.limits, curve.returns
    wanted = hinged_roof.FIRST_LIMITS[hinged_roof.THIN] * hinged_roof.FORCE
    assert limits[0].force == pytest.approx(wanted, rel=0.08)
    assert limits[-1].force < 0 < limits[0].force
    assert returns[0].deflection > returns[-1].deflection


def test_a_path_that_leads_nowhere_ends_with_the_place():
    roof = ShellRoof(hinged_roof.THICK, 8)
    path = follow_arc(roof, roof.start, Scales(0.03, 3000.0, 0.0), 0.1, lambda *_: True)
    with pytest.raises(ComputationError, match=r"no equilibrium beyond -?0 m"):
        next(path)


def test_a_curve_knows_its_turns():
    """A cubic whose force turns at deflections of 1 and 3."""
    deflections = np.linspace(0.1, 4, 40)
    force = deflections**3 / 3 - 2 * deflections**2 + 3 * deflections
    points = [hinged_roof.PathPoint(None, *pair) for pair in zip(force, deflections, strict=True)]
    curve = hinged_roof.Curve(points)
    assert [turn.deflection for turn in curve.limits] == pytest.approx([1, 3], abs=1e-3)
    assert curve.returns == []
    assert curve.force_at(2.0) == pytest.approx(2 / 3, abs=1e-4)
