"""A quarter of a shallow roof as a solid, past its first limit point; `scripts/verify 17`."""

import pytest
from verification import hinged_roof
from verification.solid_roof import solid_curve


def test_a_thick_roof_snaps_at_the_published_force():
    curve = hinged_roof.Curve(solid_curve(hinged_roof.THICK, 5, step=0.2))
    wanted = hinged_roof.FIRST_LIMITS[hinged_roof.THICK] * hinged_roof.FORCE
    assert curve.limits[0].force == pytest.approx(wanted, rel=0.05)
    assert curve.limits[1].force < curve.limits[0].force / 3
