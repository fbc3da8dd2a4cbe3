"""Decks for CalculiX: what their lines say, read back without CalculiX."""

from dataclasses import replace

import numpy as np
import pytest
from hexagon import RADIUS, hexagon_mesh, hexagon_specimen

from bilayer import Gent, InputError, LinearElastic, MooneyRivlin, NeoHookean, PlanarMesh
from bilayer.calculix.deck import (
    DeckSettings,
    abaqus_deck,
    choose_nodes_under_kirigami,
    deck_points,
    write_decks,
)
from bilayer.specimen.settings import settings_from
from bilayer.specimen.two_layers import BARE, KIRIGAMI, turned_over, with_stretched

STRETCH = (1.2, 1.1)
WEDGES = DeckSettings(element="wedge")


def blocks(deck):
    """Return the deck as (keyword line, data lines) pairs, comments left out."""
    found = []
    for line in deck.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            found.append((line, []))
        else:
            found[-1][1].append([float(word) for word in line.split(",") if word.strip()]
                                if not line[0].isalpha() else line)  # fmt: skip
    return found


def data(deck, keyword, count=1):
    """Return the data lines of the blocks of a keyword, of which there are so many."""
    found = [lines for line, lines in blocks(deck) if line.startswith(keyword)]
    assert len(found) == count, keyword
    return [row for lines in found for row in lines]


def equations(deck):
    """Return each equation as a list of (node, axis, coefficient)."""
    rows = data(deck, "*EQUATION")
    terms = [np.reshape(row, (-1, 3)) for row in rows[1::2]]
    assert [len(term) for term in terms] == [int(row[0]) for row in rows[::2]]
    return terms


def hexagon_deck(**changes):
    return abaqus_deck(replace(hexagon_specimen(), **changes), hexagon_mesh(), STRETCH, WEDGES)


def with_law(law, layer="substrate"):
    return {"layers": hexagon_specimen().with_layer(layer, material=law).layers}


def test_at_c_one_the_equations_bring_the_drawn_layers_to_the_bonded_state():
    deck, mesh, specimen = hexagon_deck(), hexagon_mesh(), hexagon_specimen()
    drawn = 1e3 * deck_points(specimen, mesh, STRETCH, "wedge")
    control = len(drawn) + 1
    covered = np.isin(mesh.region, KIRIGAMI)
    edges = np.sort(np.concatenate([mesh.triangles[covered][:, pair]
                                    for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)  # fmt: skip
    tied = len(np.unique(mesh.triangles[covered])) + len(np.unique(edges, axis=0))
    substrate = len(drawn) - 2 * tied - len(np.unique(mesh.triangles[covered]))
    factor = np.ones((len(drawn), 3))
    factor[:substrate] = (*STRETCH, 1 / np.prod(STRETCH))
    displacement = np.vstack([drawn * factor - drawn, [1.0, 0.0, 0.0]])
    found = equations(deck)
    assert len(found) == 3 * tied
    for terms in found:
        nodes, axes = terms[:, 0].astype(int) - 1, terms[:, 1].astype(int) - 1
        assert terms[:, 2] @ displacement[nodes, axes] == pytest.approx(0, abs=1e-9)
        assert terms[0, 0] <= substrate < terms[1, 0] < control


def test_every_constraint_is_on_a_node_that_no_equation_eliminates():
    deck = hexagon_deck()
    eliminated = {(int(terms[0, 0]), int(terms[0, 1])) for terms in equations(deck)}
    held = [
        (int(node), axis)
        for node, first, last, *_ in data(deck, "*BOUNDARY")
        for axis in range(int(first), int(last) + 1)
    ]
    loaded = [(int(node), int(axis)) for node, axis, _ in data(deck, "*CLOAD")]
    assert len(held) == 6 + 1
    assert len(loaded) == len(hexagon_mesh().points)
    assert not eliminated & {*held, *loaded}


def test_held_nodes_carry_kirigami_where_the_nearest_ones_are_bare():
    mesh = hexagon_mesh()
    usual = choose_nodes_under_kirigami(mesh, 0.0)
    bare = np.isin(mesh.triangles, usual[1:]).any(axis=1)
    cut = PlanarMesh(mesh.points, mesh.triangles, np.where(bare, BARE, KIRIGAMI))
    held = choose_nodes_under_kirigami(cut, 0.0)
    assert held[0] == usual[0]
    assert len({*held}) == 3
    assert np.isin(held, cut.triangles[~bare]).all()


def test_the_saddle_load_vanishes_at_the_end_and_is_in_balance():
    deck, mesh, specimen = hexagon_deck(), hexagon_mesh(), hexagon_specimen()
    assert data(deck, "*AMPLITUDE") == [[0, 1, 1, 0]]
    forces = np.array(data(deck, "*CLOAD"))[:, 2]
    assert forces.sum() == pytest.approx(0, abs=1e-6 * np.abs(forces).max())
    at_rim = int(np.argmax(mesh.points[:, 0]))
    share = mesh.areas[(mesh.triangles == at_rim).any(axis=1)].sum() / 3
    substrate = specimen.layer("substrate")
    mass = substrate.density * substrate.thickness * share
    assert forces[at_rim] == pytest.approx(mass * DeckSettings().imperfection, rel=1e-5)
    assert "*CLOAD" not in abaqus_deck(
        specimen, mesh, STRETCH, DeckSettings(element="wedge", imperfection=0.0)
    )


@pytest.mark.parametrize(
    ("law", "keyword", "constants"),
    [
        (MooneyRivlin(4871.4, 14633.7, 1e-6), "*HYPERELASTIC, MOONEY-RIVLIN",
         [0.0048714, 0.0146337, 1.0]),
        (NeoHookean(19505.0, d1=1e-6), "*HYPERELASTIC, NEO HOOKE", [0.019505, 1.0]),
    ],
)  # fmt: skip
def test_hyperelastic_constants_are_in_megapascals(law, keyword, constants):
    others = 0 if "NEO" in keyword else 1
    rows = data(hexagon_deck(**with_law(law)), keyword, 1 + others)
    assert rows[0] == pytest.approx(constants)


def test_the_linear_law_has_the_energy_of_the_strain_with_its_initial_part():
    law = LinearElastic(116250.0, 0.4)
    deck = hexagon_deck(**with_law(law))
    d = [value for row in data(deck, "*ELASTIC, TYPE=ORTHO") for value in row]
    stiffness = np.diag([d[0], d[2], d[5]])
    stiffness[0, 1], stiffness[0, 2], stiffness[1, 2] = d[1], d[3], d[4]
    stiffness += np.triu(stiffness, 1).T
    shear = np.array([[0, d[6], d[7]], [d[6], 0, d[8]], [d[7], d[8], 0]])
    initial = np.array([0.2, 0.1, -0.4 / 0.6 * 0.3])
    scale = np.sqrt(1 - 2 * initial)
    gradient = np.eye(3) + 0.2 * np.random.default_rng(1).normal(size=(3, 3))  # from bonded flat
    strain = (gradient.T @ gradient - np.eye(3)) / 2 + np.diag(initial)
    deviator = strain - np.trace(strain) / 3 * np.eye(3)
    expected = (
        law.shear_modulus * (deviator**2).sum() + law.bulk_modulus / 2 * np.trace(strain) ** 2
    )
    drawn = gradient @ np.diag(1 / scale)
    green = (drawn.T @ drawn - np.eye(3)) / 2
    found = np.diag(green) @ stiffness @ np.diag(green) / 2 + (shear * green**2).sum()
    assert 1e6 * found * np.prod(scale) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize(
    ("law", "named"),
    [
        (MooneyRivlin(4839.1, 14536.0), "substrate.d1 = 0"),
        (NeoHookean(19375.0), "substrate.d1 = 0"),
        (LinearElastic(116250.0, 0.5), "substrate.poisson_ratio = 0.5"),
    ],
)
def test_an_incompressible_law_is_refused_by_name(law, named):
    with pytest.raises(InputError, match=f"{named}: CalculiX has no incompressible law"):
        hexagon_deck(**with_law(law))


def test_a_law_without_keyword_is_refused_by_name():
    with pytest.raises(InputError, match="law = 'gent': a deck has no keyword for it"):
        hexagon_deck(**with_law(Gent(2e4, 9.0, 1e-6)))


def test_weight_acts_on_the_mass_that_is_drawn():
    assert "GRAV" not in hexagon_deck()
    deck = hexagon_deck(gravity=9.81, **with_law(LinearElastic(116250.0, 0.4)))
    assert data(deck, "*DLOAD") == [
        "SUBSTRATE, GRAV, 9810, 0., 0., -1.", "KIRIGAMI, GRAV, 9810, 0., 0., -1."
    ]  # fmt: skip
    densities = [row[0] for row in data(deck, "*DENSITY", 2)]
    scale = np.sqrt([1 - 0.4, 1 - 0.2, 1 + 2 * 0.4 / 0.6 * 0.3])
    assert densities == pytest.approx([960e-12 / np.prod(scale), 960e-12])


def test_the_deck_says_what_it_is_of():
    deck = hexagon_deck(name="größer")
    assert "prestretch 1.2 x 1.1" in deck
    assert "** [substrate]" in deck
    assert deck.isascii()


def test_each_milestone_has_a_deck_of_its_own(tmp_path):
    specimen, mesh = hexagon_specimen((1.03, (1.06, 1.05))), hexagon_mesh()
    names = write_decks(specimen, mesh, tmp_path / "deck.inp", WEDGES)
    assert [path.name for path in names] == ["deck_1.03.inp", "deck_1.06.inp"]
    texts = [path.read_text() for path in names]
    assert "prestretch 1.03 x 1.03" in texts[0]
    assert "prestretch 1.06 x 1.05" in texts[1]
    only = write_decks(specimen.with_milestones([1.03]), mesh, tmp_path / "deck.inp", WEDGES)
    assert only == [tmp_path / "deck.inp"]


def test_the_kirigami_below_and_stretched_lies_below_and_is_drawn_smaller():
    specimen = hexagon_specimen()
    turned = turned_over(with_stretched(specimen, ["kirigami"]))
    points = deck_points(turned, hexagon_mesh(), STRETCH, "wedge")
    usual = deck_points(specimen, hexagon_mesh(), STRETCH, "wedge")
    below, above = points[points[:, 2] < 0], points[points[:, 2] > 0]
    assert np.abs(below[:, 0]).max() == pytest.approx(RADIUS / STRETCH[0])
    assert np.abs(above[:, 0]).max() == pytest.approx(RADIUS)
    assert len(points) == len(usual)


def test_settings_are_checked():
    with pytest.raises(InputError, match=r"solver.element = 'brick'"):
        DeckSettings(element="brick")
    with pytest.raises(InputError, match=r"solver.first_increment = 0.5: expected at most"):
        settings_from(DeckSettings, {"first_increment": "0.5"})
