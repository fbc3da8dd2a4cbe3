"""Layers that lie on a triangle are bonded to each other, without a gap."""

from dataclasses import replace
from itertools import product

import pytest
from grids import grid_mesh

from bilayer import InputError, paper_specimen
from bilayer.mesh.bonding import check_bonding, check_no_gap
from bilayer.mesh.planar import PlanarMesh

NAMES = ("bottom", "middle", "top")


def pile(*layers):
    """Return three layers and two triangles: all lie on one of them, some on the other."""
    two = paper_specimen()
    middle, skin = two.layer("substrate"), two.layer("kirigami")
    named = [
        replace(part, name=name, pattern=None)
        for part, name in zip((skin, middle, skin), NAMES, strict=True)
    ]
    specimen = replace(two, layers=tuple(named))
    mesh = grid_mesh([(0, 0)])
    sets = (frozenset(NAMES), frozenset(layers))
    return specimen, PlanarMesh(mesh.points, mesh.triangles, [0, 1], sets)


@pytest.mark.parametrize(
    "there", [there for there in product([True, False], repeat=3) if any(there)]
)
def test_a_layer_that_is_missing_between_two_is_named(there):
    layers = [name for name, lies in zip(NAMES, there, strict=True) if lies]
    if layers != ["bottom", "top"]:
        check_no_gap(*pile(*layers))
        return
    message = (
        r"layers\.middle\.pattern: it is cut away between bottom and top on 1 triangles, "
        "expected no gap between layers that lie there"
    )
    with pytest.raises(InputError, match=message):
        check_no_gap(*pile(*layers))


@pytest.mark.parametrize("there", [("bottom",), ("top",)])
def test_the_reference_surface_lies_everywhere(there):
    message = (
        r"layers\.middle\.pattern: it is cut away on 1 triangles, expected the reference surface, "
        "middle of middle, everywhere on the sheet"
    )
    with pytest.raises(InputError, match=message):
        check_bonding(*pile(*there))
    check_bonding(*pile("middle"))


def test_either_of_two_layers_has_their_bond():
    specimen, mesh = paper_specimen(), grid_mesh([(0, 0)])
    sets = (frozenset({"substrate"}), frozenset({"kirigami"}))
    check_bonding(specimen, PlanarMesh(mesh.points, mesh.triangles, [0, 1], sets))


def test_a_mesh_of_other_layers_is_refused():
    _, mesh = pile("bottom")
    with pytest.raises(InputError, match="mesh: has triangles of a layer 'bottom', expected layer"):
        check_no_gap(paper_specimen(), mesh)
