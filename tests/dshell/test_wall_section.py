"""The section across a wall where layers end: closed forms, and its own mesh."""

from dataclasses import replace

import numpy as np
import pytest

from dshell.models.wall_section import FIRST_CELL, GROWTH, Ply, wall_compliance

ST_VENANT = 0.630249 / 2
"""What a wall takes from the width of a strip in torsion, over its thickness."""
PLATE = Ply(-1e-3, 1e-3, 1e5, 0.4, ends=True)
SUBSTRATE, KIRIGAMI = (Ply(-1.1e-3, 0.0, 1.3e5, 0.39, False), Ply(0.0, 1.6e-3, 4.6e5, 0.12, True))


def test_a_plate_loses_at_its_rim_what_st_venants_torsion_says():
    twisted = PLATE.shear_modulus * PLATE.thickness**3 / 12
    found = wall_compliance((PLATE,)).along[1, 1] * twisted
    assert found / PLATE.thickness == pytest.approx(ST_VENANT, rel=2e-3)


def test_a_plate_loses_nothing_else():
    """At a rim there is no force, no moment, and no stress without them."""
    found = wall_compliance((PLATE,))
    scale = 1 / (PLATE.plane_strain_modulus * PLATE.thickness)
    assert np.abs(found.across).max() < 1e-12 * scale / PLATE.thickness
    assert np.abs(found.along[0]).max() < 1e-12 * scale / PLATE.thickness


def test_plates_of_one_material_on_each_other_are_one_plate():
    halves = [Ply(-1e-3, 0.0, 1e5, 0.4, True), Ply(0.0, 1e-3, 1e5, 0.4, True)]
    stiff = PLATE.shear_modulus * PLATE.thickness
    height = np.array([-0.5e-3, 0.5e-3])
    twist = PLATE.shear_modulus * np.array([1e-3 * height, [1e-9 / 12] * 2]).T.reshape(-1)
    found = twist @ wall_compliance(tuple(halves)).along @ twist
    whole = wall_compliance((PLATE,)).along[1, 1] * (stiff * PLATE.thickness**2 / 12) ** 2
    assert found == pytest.approx(whole, rel=5e-3)


@pytest.mark.parametrize("part", ["across", "along"])
def test_it_is_within_a_percent_of_its_limit_on_finer_meshes(part):
    coarse, fine = (
        getattr(wall_compliance((SUBSTRATE, KIRIGAMI), *mesh), part)
        for mesh in ((FIRST_CELL, GROWTH), (0.01, 1.3))
    )
    assert coarse == pytest.approx(fine, rel=0.01)


def test_it_does_not_depend_on_where_heights_are_counted_from():
    here = wall_compliance((SUBSTRATE, KIRIGAMI))
    plies = [replace(p, bottom=p.bottom + 1e-3, top=p.top + 1e-3) for p in (SUBSTRATE, KIRIGAMI)]
    there = wall_compliance(tuple(plies))
    assert there.across == pytest.approx(here.across, rel=1e-6)
    assert there.along == pytest.approx(here.along, rel=1e-6)


def test_upside_down_the_moments_change_their_sign():
    here = wall_compliance((SUBSTRATE, KIRIGAMI))
    plies = [replace(p, bottom=-p.top, top=-p.bottom) for p in (KIRIGAMI, SUBSTRATE)]
    there = wall_compliance(tuple(plies))
    sign = np.array([1.0, -1.0])
    assert there.across == pytest.approx(sign[:, None] * here.across * sign, rel=1e-6)
    assert there.along == pytest.approx(sign[:, None] * here.along * sign, rel=1e-6)
