"""Meshes that move with the cuts: nodes on cuts and rim stay there, no triangle turns over."""

from dataclasses import replace

import numpy as np
import pytest

import bilayer
from bilayer import InputError
from bilayer.designing.equilibria import SheetMesh
from bilayer.designing.mesh_motion import move_points
from bilayer.designing.variables import value_of, with_values
from bilayer.mesh.agreement import check_agreement

CHANGES = {
    "kirigami.pattern.inner_radius": 0.0105,
    "kirigami.pattern.half_angles.0": 0.2,
    "kirigami.pattern.half_angles.2": 0.12,
}


@pytest.fixture(scope="module")
def mesh(profiled):
    return bilayer.generate_mesh(profiled)


def test_a_moved_mesh_is_one_of_the_changed_specimen(profiled, mesh):
    changed = with_values(profiled, CHANGES)
    moved = SheetMesh(profiled, mesh).of(changed)
    check_agreement(changed, moved)
    with pytest.raises(InputError):
        check_agreement(changed, mesh)
    assert moved.areas.min() > 0


def test_there_and_back(profiled, mesh):
    changed = with_values(profiled, CHANGES)
    there = move_points(mesh.points, profiled, changed)
    away = np.abs(move_points(there, changed, profiled) - mesh.points).max(axis=1)
    beyond = np.linalg.norm(mesh.points, axis=1) > 0.008
    assert away[beyond].max() < 1e-12
    assert away.max() < 1e-4  # within, turns fade
    assert move_points(mesh.points, profiled, profiled) is mesh.points


def test_an_ellipse_grows_with_its_cuts(profiled):
    ellipse = replace(profiled, outline=bilayer.Ellipse(0.08, 0.06))
    mesh = bilayer.generate_mesh(ellipse)
    changed = with_values(ellipse, {"outline.width": 0.09, "kirigami.pattern.half_angles.1": 0.2})
    check_agreement(changed, SheetMesh(ellipse, mesh).of(changed))


def test_the_bends_of_a_profile_stay_where_they_are_as_the_outline_grows(profiled):
    bent = bilayer.SectorProfile(5, (0.008, 0.015, 0.022, 0.028), (0.12, 0.30, 0.14, 0.30))
    ellipse = replace(profiled, outline=bilayer.Ellipse(0.08, 0.06)).with_layer(
        "kirigami", pattern=bent
    )
    sheet = SheetMesh(ellipse, bilayer.generate_mesh(ellipse))
    for change in (
        {"outline.width": 0.09},
        {"outline.width": 0.075, "outline.height": 0.065, "kirigami.pattern.inner_radius": 0.009},
    ):
        changed = with_values(ellipse, change)
        check_agreement(changed, sheet.of(changed))


def test_equal_sectors_open():
    specimen = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.008))
    changed = with_values(specimen, {"kirigami.pattern.cutout_angle": 0.4})
    check_agreement(changed, SheetMesh(specimen, bilayer.generate_mesh(specimen)).of(changed))


def test_the_velocity_is_the_derivative_of_the_motion(profiled, mesh):
    sheet, name = SheetMesh(profiled, mesh), "kirigami.pattern.half_angles.1"
    step = 1e-4
    changed = with_values(profiled, {name: value_of(profiled, name) + step})
    moved = move_points(mesh.points, profiled, changed)
    difference = (moved - mesh.points) / step
    velocity = sheet.velocity(profiled, name)
    assert np.abs(difference - velocity).max() < 0.01 * np.abs(velocity).max()


def test_a_drawn_pattern_does_not_move(profiled):
    square = bilayer.Polygons((((0, 0), (0.01, 0), (0.01, 0.01), (0, 0.01)),))
    drawn = profiled.with_layer("kirigami", pattern=square)
    with pytest.raises(InputError, match="sector-profile"):
        move_points(np.zeros((1, 2)), drawn, profiled)
