"""The load that breaks symmetries leaves no resultant and no moment, whatever it acts on."""

from dataclasses import replace

import numpy as np
import pytest

from bilayer import CutPattern, MeshSize, generate_mesh, paper_specimen
from bilayer.geometry.saddle_load import SaddleLoad

R = 0.04


def plates():
    """Discs whose layers are as uneven as can be, and one drawn out and moved away."""
    coarse = replace(paper_specimen(), mesh=MeshSize(0.008))
    meshes = [
        generate_mesh(coarse.with_layer("kirigami", pattern=CutPattern(*cut)))
        for cut in ((1, 0.008, 5.0), (2, 0.01, 0.2), (3, 0.008, 1.0), (5, 0.008, 0.3))
    ]
    drawn = meshes[0].points * [1.7, 0.6] + [0.03, -0.02]
    return [(m.points, m.triangles[m.region == 1]) for m in meshes] + [(drawn, meshes[0].triangles)]


def moments(points, masses, load):
    """Resultant and moments over what they would be if all of the load pulled one way."""
    forces = masses * load.at(*points.T)
    rigid = np.column_stack([np.ones(len(points)), points / R])
    return forces @ rigid / (np.abs(forces) @ np.abs(rigid))


@pytest.mark.parametrize("plate", plates())
def test_a_plate_is_left_where_it_is(plate):
    """Integrated by another rule than the load is made with: Gauss points of a collapsed square."""
    points, triangles = plate
    load = SaddleLoad.on_plate(points, triangles, R)
    places, areas = np.empty((0, 2)), np.empty(0)
    n = 6
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    double = np.abs(np.linalg.det(np.stack([b - a, c - a], axis=1)))
    for s, ws in zip(*np.polynomial.legendre.leggauss(n), strict=True):
        for t, wt in zip(*np.polynomial.legendre.leggauss(n), strict=True):
            u, v = (1 + s) / 2, (1 + t) / 2 * (1 - (1 + s) / 2)
            places = np.vstack([places, a + u * (b - a) + v * (c - a)])
            areas = np.append(areas, double * ws * wt * (1 - u) / 4)
    assert np.abs(moments(places, areas, load)).max() < 1e-12
    assert np.abs(load.at(*places.T)).max() > 0.1


def test_uneven_masses_are_left_where_they_are():
    points = np.random.default_rng(1).normal(scale=R, size=(40, 2))
    masses = np.random.default_rng(2).uniform(0.1, 3.0, size=40)
    load = SaddleLoad.on_points(points, masses, R)
    assert np.abs(moments(points, masses, load)).max() < 1e-12


def test_on_an_even_disc_it_is_the_plain_saddle():
    angles = 2 * np.pi * np.arange(12) / 12
    rim = R * np.column_stack([np.cos(angles), np.sin(angles)])
    load = SaddleLoad.on_points(rim, np.ones(12), R)
    assert load.at(*rim.T) == pytest.approx(np.cos(2 * angles), abs=1e-12)
    assert not np.any(load.affine)
