"""Layers that lie on each other, and those that do not."""

import numpy as np
import pytest

from bilayer import Layer, MooneyRivlin, PlanarMesh, Prestretch, Rectangle, Response, Specimen
from bilayer.errors import InputError
from bilayer.mesh.generation import mesh_within_memory
from bilayer.mesh.layering import check_layering

TAPE = MooneyRivlin(4839.1, 14536.0)


def sheet(*names):
    """A sheet of these layers from the bottom up, the one named `core` stretched."""
    layers = [
        Layer(name, 1e-3, TAPE, response=Response("path" if name == "core" else "none"))
        for name in names
    ]
    return Specimen(Rectangle(0.02, 0.02), layers, Prestretch([1.1]))


def square(*sets):
    """A square of two triangles with these layers on them."""
    points = [[-0.01, -0.01], [0.01, -0.01], [0.01, 0.01], [-0.01, 0.01]]
    region = np.arange(2) % len(sets)
    return PlanarMesh(points, [[0, 1, 2], [0, 2, 3]], region, [frozenset(names) for names in sets])


@pytest.mark.parametrize(
    "sets",
    [
        [{"low", "core", "high"}],
        [{"core"}, {"low", "core"}],
        [{"core", "high"}, {"low", "core", "high"}],
    ],
)
def test_layers_on_each_other_are_taken(sets):
    check_layering(sheet("low", "core", "high"), square(*sets))


def test_either_of_two_layers_has_their_bond():
    check_layering(sheet("core", "high"), square({"core"}, {"high"}))


def test_a_gap_is_refused():
    specimen = sheet("core", "soft", "high")
    with pytest.raises(InputError) as error:
        mesh_within_memory(specimen, square({"core"}, {"core", "high"}), 1.0, "the solver")
    assert str(error.value) == (
        "layers.soft: is cut away at (-0.003333, 0.003333) m between core and high, "
        "expected no gap between layers"
    )


def test_a_sheet_without_its_reference_surface_somewhere_is_refused():
    with pytest.raises(InputError, match=r"layers\.core: does not lie at .* middle of core"):
        check_layering(sheet("low", "core", "high"), square({"low", "core"}, {"low"}))


def test_a_layer_that_the_specimen_lacks_is_refused():
    with pytest.raises(InputError, match=r"mesh: has a layer 'hi' .* one of core, high"):
        check_layering(sheet("core", "high"), square({"core"}, {"core", "hi"}))
