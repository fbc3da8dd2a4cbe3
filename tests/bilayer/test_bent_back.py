"""The search for places that are bent back: it misses none that are nearest, and stays small."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from bilayer import MeshSize, generate_mesh, paper_specimen
from bilayer.contact.bent_back import BENT_BACK, Balls, Places, bent_back_pairs
from bilayer.contact.self_contact import self_contact_gap
from bilayer.contact.skin import BondedBody


def rolled_strip(turns, count=400):
    """Places along a spiral of some turns, with balls around them, and their chain of nodes."""
    s = np.sort(np.random.default_rng(2).uniform(0, 1, count))
    angle, radius = 2 * np.pi * turns * s, 0.1 + 0.05 * s
    points = np.zeros(count)
    spiral = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), points])
    length = np.column_stack([0.125 * angle, points, points])
    places = Places(Balls(length, points), Balls(spiral, points), Balls(spiral, points + 1e-4))
    nodes = np.arange(count)[:, None] + np.arange(3)
    return places, length, nodes


def every_pair(places, nodes, reach):
    """The rule itself, on all pairs of triangles."""
    pairs = np.column_stack(np.triu_indices(len(nodes), 1))
    one, other = pairs.T

    def apart(balls):
        return np.linalg.norm(balls.centres[one] - balls.centres[other], axis=1)

    skin = apart(places.skin) - places.skin.radii[one] - places.skin.radii[other]
    far = np.abs(one - other) > 2  # share no node of the chain
    bent_back = apart(places.chord) < BENT_BACK * apart(places.natural)
    return pairs[bent_back & far & (skin <= reach)], skin[bent_back & far & (skin <= reach)]


@pytest.mark.parametrize("turns", [0.5, 0.9, 1.5, 3.3])
@pytest.mark.parametrize("reach", [0.016, 0.3])
def test_it_finds_what_is_nearest_and_nothing_else(turns, reach):
    places, flat, nodes = rolled_strip(turns)
    expected, distance = every_pair(places, nodes, reach)
    found = {tuple(sorted(pair)) for pair in bent_back_pairs(places, flat, nodes, reach).tolist()}
    assert found <= set(map(tuple, expected.tolist()))
    assert bool(found) == bool(len(expected))
    if len(expected):
        assert tuple(expected[np.argmin(distance)].tolist()) in found


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_few_places(count):
    places, flat, nodes = rolled_strip(0.5, count)
    assert bent_back_pairs(places, flat, nodes, 1.0).shape == (0, 2)


def peak_memory(size, radius=0.012):
    """Of the search on the disc, rolled to a tube that is still open, bytes; its triangles."""
    specimen = paper_specimen()
    mesh = generate_mesh(replace(specimen, mesh=MeshSize(size)))
    body = BondedBody.of(specimen, mesh, (1.15, 1.15))
    x, y = mesh.points.T
    position = np.column_stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)])
    tracemalloc.start()
    try:
        self_contact_gap(body, position)
        return tracemalloc.get_traced_memory()[1], len(mesh.triangles)
    finally:
        tracemalloc.stop()


def test_memory_does_not_grow_faster_than_the_mesh():
    """All pairs within a thickness would be sixteen times as many on four times the triangles."""
    coarse, few = peak_memory(0.0025)
    fine, many = peak_memory(0.00125)
    assert fine / coarse < 1.3 * many / few
