"""A specimen as an input deck in Abaqus' keywords, which CalculiX runs as it is.

Each layer is drawn in its natural state (`bilayer.calculix.drawn_layer`). At the interface they are
tied node by node and direction by direction,

    u_substrate - u_kirigami - (X_kirigami - X_substrate) c = 0,

c being the displacement of a control node that the one step takes from 0, where nothing is
stressed, to 1, where the drawn places agree and the body is the bonded one. Shapes at c < 1 mean
nothing. docs/calculix.md says why it is done in this way.

Lengths are in mm, stresses in MPa, masses in tonnes.
"""

import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import singledispatch
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.calculix.drawn_layer import INTERFACE, DrawnLayer, draw_layer
from bilayer.calculix.quadratic_mesh import ELEMENTS, QuadraticMesh, quadratic_mesh
from bilayer.errors import InputError
from bilayer.geometry.saddle_load import SaddleLoad
from bilayer.mesh.agreement import check_agreement
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.runtime.output_file import check_writable, whole_file
from bilayer.runtime.version import __version__
from bilayer.specimen.layer import BondedLayer
from bilayer.specimen.materials import Law, LinearElastic, MooneyRivlin, NeoHookean
from bilayer.specimen.settings import setting
from bilayer.specimen.specimen import (
    KIRIGAMI_LAYER,
    Specimen,
    refuse_fields,
    refuse_loading,
    refuse_obstacles,
    refuse_time,
)
from bilayer.specimen.support import HeldNodes, choose_held_nodes
from bilayer.specimen.toml import specimen_to_toml
from bilayer.specimen.two_layers import LAYERS, TwoLayers
from bilayer.validation import finite, keep, one_of, positive

MM_PER_M, MEGAPASCALS, TONNES_PER_MM3 = 1e3, 1e-6, 1e-12


@dataclass(frozen=True)
class DeckSettings:
    """Settings of a deck: its elements, increments and imperfection.

    Raises
    ------
    InputError
        A value is out of its range.
    """

    element: str = setting(
        "hexahedron",
        "'hexahedron': pairs of triangles are C3D20R, those left over C3D15; 'wedge': all C3D15",
    )
    first_increment: float = setting(0.05, "first increment of the control displacement c [1]")
    largest_increment: float = setting(0.2, "largest increment of c [1]")
    smallest_increment: float = setting(1e-5, "increment below which the program gives up [1]")
    imperfection: float = setting(
        0.1,
        "saddle-shaped vertical load that breaks the symmetry, acceleration of the substrate at "
        "the rim, gone at c = 1 [m/s2]",
    )

    def __post_init__(self) -> None:
        keep(self, one_of, "element", table="solver.", choices=ELEMENTS)
        keep(self, finite, "imperfection", table="solver.")
        increments = ("smallest_increment", "first_increment", "largest_increment")
        keep(self, positive, *increments, table="solver.")
        for smaller, larger in pairwise(increments):
            if getattr(self, smaller) > getattr(self, larger):
                raise InputError(
                    f"solver.{smaller} = {getattr(self, smaller)!r}: expected at most "
                    f"solver.{larger} = {getattr(self, larger)!r}"
                )


@dataclass(frozen=True, eq=False)
class _Part:
    """A drawn layer and where its numbers in the deck begin."""

    bonded: BondedLayer
    drawn: DrawnLayer
    scale: tuple[float, float, float]
    first_node: int
    first_element: int

    @property
    def name(self) -> str:
        """Name of the layer in the deck."""
        return self.bonded.name.upper()

    def nodes(self, level: int) -> NDArray[np.int64]:
        """Return the node number over each point of the quadratic mesh, 0 if there is none."""
        at = self.drawn.node_at[level]
        return np.where(at < 0, 0, at + self.first_node)

    def place(self, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the drawn positions of some nodes, m, shape (nodes, 3)."""
        return self.drawn.points[nodes - self.first_node]

    @property
    def elements(self) -> int:
        """Number of elements."""
        return len(self.drawn.wedges) + len(self.drawn.hexahedra)


def write_decks(
    specimen: Specimen, mesh: PlanarMesh, path: str | Path, settings: DeckSettings
) -> list[Path]:
    """Write a deck for each milestone; more than one get the prestretch before the ending.

    Returns
    -------
    list of Path
        The files, as in deck_1.03.inp, deck_1.06.inp.

    Raises
    ------
    InputError
        A material cannot be had, the mesh is not one of the specimen, or the folder cannot be
        written.
    ComputationError
        Writing failed, for example on a full disk.
    """
    refuse_loading(specimen, "a CalculiX deck")
    refuse_time(specimen, "a CalculiX deck")
    refuse_fields(specimen, "a CalculiX deck")
    refuse_obstacles(specimen, "a CalculiX deck")
    check_agreement(specimen, mesh)
    names = deck_names(specimen, path)
    for name in names:
        check_deck_output(name)
    for name, milestone in zip(names, specimen.prestretch.milestones, strict=True):
        deck = abaqus_deck(specimen, mesh, milestone, settings)
        with whole_file(name, "deck") as partial:
            partial.write_text(deck, encoding="ascii")
    return names


def deck_names(specimen: Specimen, path: str | Path) -> list[Path]:
    """Return the names of the decks of a specimen, one for each milestone."""
    target, stretches = Path(path), specimen.prestretch.nominal
    if len(stretches) == 1:
        return [target]
    return [target.with_name(f"{target.stem}_{s:.10g}{target.suffix}") for s in stretches]


def check_deck_output(path: str | Path, inputs: Iterable[str | Path] = ()) -> None:
    """Raise InputError unless a deck can be written, and CalculiX finds it: by .inp.

    Parameters
    ----------
    path : path-like
        Where it shall be.
    inputs : iterable of path-like
        Files that are read and must not be lost.
    """
    check_writable(path, inputs)
    if Path(path).suffix != ".inp":
        raise InputError(f"output file {path}: is a deck of CalculiX, expected an ending of .inp")


def abaqus_deck(
    specimen: Specimen, mesh: PlanarMesh, stretch: tuple[float, float], settings: DeckSettings
) -> str:
    """Return the text of the deck of one prestretch.

    Parameters
    ----------
    specimen : Specimen
        What to release; its milestones do not matter.
    mesh : PlanarMesh
        Nodes 1 to n of the deck are the interface nodes of the substrate over its n nodes.
    stretch : (float, float)
        (lambda_x, lambda_y) of the substrate.
    settings : DeckSettings
        How it is meshed and stepped.

    Raises
    ------
    InputError
        A material has no compressibility, which CalculiX needs, or no natural state.
    """
    parts = _parts(specimen, mesh, stretch, settings.element)
    last = parts[-1]
    control = last.first_node + len(last.drawn.points)
    blocks = [
        *_header(specimen, stretch, settings),
        *(line for part in parts for line in _mesh_of(part)),
        "** the control node, whose displacement along x is c",
        "*NODE, NSET=CONTROL", f"{control}, 0., 0., 0.",
        *(line for part in parts for line in _material_of(part, bool(specimen.gravity))),
        *_ties(*parts, control),
        *_step(specimen, mesh, parts, control, settings),
    ]  # fmt: skip
    return "\n".join(blocks) + "\n"


def deck_points(
    specimen: Specimen, mesh: PlanarMesh, stretch: tuple[float, float], element: str
) -> NDArray[np.float64]:
    """Return the drawn positions of the deck's nodes, in the order of their numbers, m, (k, 3).

    The first are those of the substrate at the interface, over the nodes of the planar mesh.
    """
    parts = _parts(specimen, mesh, stretch, element)
    return np.concatenate([part.drawn.points for part in parts])


def _parts(
    specimen: Specimen, mesh: PlanarMesh, stretch: tuple[float, float], element: str
) -> tuple[_Part, _Part]:
    TwoLayers.of(specimen, "CalculiX deck")
    cells = quadratic_mesh(mesh, element)
    substrate, kirigami = (specimen.bonded_layer(name, stretch) for name in LAYERS)
    first = _part(cells, substrate, 1, 1)
    return first, _part(cells, kirigami, 1 + len(first.drawn.points), 1 + first.elements)


def _part(cells: QuadraticMesh, bonded: BondedLayer, node: int, element: int) -> _Part:
    scale = bonded.layer.material.natural_scale(bonded.axial_stretch)
    return _Part(bonded, draw_layer(cells, bonded, scale), scale, node, element)


def _header(
    specimen: Specimen, stretch: tuple[float, float], settings: DeckSettings
) -> Iterator[str]:
    x, y = stretch
    yield "*HEADING"
    yield f"Bilayer {_ascii(specimen.name)!r}, prestretch {x:.10g} x {y:.10g}"
    words = (
        f"Written by bilayer-shells {__version__} for CalculiX; Abaqus needs the changes that are "
        "listed in docs/calculix.md. Units: mm, N, MPa, tonne, s. Each layer is drawn in its "
        "natural state; equations with the displacement c of the control node bring the "
        "interfaces together. Only the shape at c = 1, the end of the step, has a meaning. "
        f"Settings: {', '.join(f'{name} = {value!r}' for name, value in vars(settings).items())}. "
        "The specimen, in SI units:"
    )
    lines = [*textwrap.wrap(words, 90), "", *specimen_to_toml(specimen).splitlines()]
    yield from (f"** {_ascii(line)}" for line in lines)


def _ascii(text: str) -> str:
    return text.encode("ascii", "replace").decode()


def _mesh_of(part: _Part) -> Iterator[str]:
    yield f"*NODE, NSET=N{part.name}"
    places: Any = (MM_PER_M * part.drawn.points).tolist()
    for number, place in enumerate(places, start=part.first_node):
        yield f"{number}, " + ", ".join(f"{value:.12g}" for value in place)
    first = part.first_element
    for kind, elements in (("C3D20R", part.drawn.hexahedra), ("C3D15", part.drawn.wedges)):
        if len(elements):
            yield f"*ELEMENT, TYPE={kind}, ELSET={part.name}"
        rows: Any = (elements + part.first_node).tolist()
        for number, nodes in enumerate(rows, start=first):
            words = [str(number), *map(str, nodes)]
            yield ", ".join(words[:11]) + ","
            yield ", ".join(words[11:])
        first += len(elements)


def _material_of(part: _Part, heavy: bool) -> Iterator[str]:
    yield f"*MATERIAL, NAME={part.name}"
    yield from _law_card(part.bonded.layer.material, part.scale, part.name.lower())
    if heavy:
        density = part.bonded.layer.density / float(np.prod(part.scale))
        yield from ("*DENSITY", f"{TONNES_PER_MM3 * density:.10g}")
    yield f"*SOLID SECTION, ELSET={part.name}, MATERIAL={part.name}"


@singledispatch
def _law_card(law: Law, scale: tuple[float, float, float], field: str) -> Iterator[str]:
    raise InputError(
        f"{field}.law = {law.name!r}: a deck has no keyword for it, expected 'mooney-rivlin', "
        "'neo-hookean' or 'linear'"
    )


@_law_card.register
def _(law: MooneyRivlin, scale: tuple[float, float, float], field: str) -> Iterator[str]:
    constants = _constants(law, field)
    yield "*HYPERELASTIC, MOONEY-RIVLIN"
    yield ", ".join(f"{value:.10g}" for value in constants)


@_law_card.register
def _(law: NeoHookean, scale: tuple[float, float, float], field: str) -> Iterator[str]:
    c10, _, d1 = _constants(law, field)
    yield "*HYPERELASTIC, NEO HOOKE"
    yield f"{c10:.10g}, {d1:.10g}"


@_law_card.register
def _(law: LinearElastic, scale: tuple[float, float, float], field: str) -> Iterator[str]:
    """Stiffnesses of the strain E' = A^-1 E A^-1, A the natural scale, per drawn volume.

    D'_iijj = a_i^2 a_j^2 D_iijj / det A, and so for the shears.
    """
    if law.poisson_ratio == 0.5:
        raise _incompressible(f"{field}.poisson_ratio = 0.5")
    mu = MEGAPASCALS * law.shear_modulus
    lame = MEGAPASCALS * law.bulk_modulus - 2 * mu / 3
    pairs = [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]
    direct = [lame + 2 * mu * (i == j) for i, j in pairs]
    shears = [(0, 1), (0, 2), (1, 2)]
    squares = np.square(scale)
    values = [
        value * squares[i] * squares[j] / float(np.prod(scale))
        for value, (i, j) in zip([*direct, mu, mu, mu], [*pairs, *shears], strict=True)
    ]
    yield "*ELASTIC, TYPE=ORTHO"
    yield ", ".join(f"{value:.10g}" for value in values[:8]) + ","
    yield f"{values[8]:.10g}"


def _constants(law: MooneyRivlin, field: str) -> tuple[float, float, float]:
    """C10, C01 in MPa and D1 in 1/MPa."""
    if law.d1 == 0:
        raise _incompressible(f"{field}.d1 = 0")
    return MEGAPASCALS * law.c10, MEGAPASCALS * law.c01, law.d1 / MEGAPASCALS


def _incompressible(what: str) -> InputError:
    return InputError(
        f"{what}: CalculiX has no incompressible law (it would take a Poisson ratio of 0.475), "
        "expected a Poisson ratio below 0.5, such as 0.499"
    )


def _ties(substrate: _Part, kirigami: _Part, control: int) -> Iterator[str]:
    """Yield the equations that bring the interfaces together; the first term is eliminated."""
    first, second = substrate.nodes(INTERFACE), kirigami.nodes(INTERFACE)
    tied = second > 0
    first, second = first[tied], second[tied]
    gaps: Any = (MM_PER_M * (kirigami.place(second) - substrate.place(first))).tolist()
    yield "*EQUATION"
    for a, b, gap in zip(first, second, gaps, strict=True):
        for axis, distance in enumerate(gap, start=1):
            terms = f"{a}, {axis}, 1., {b}, {axis}, -1."
            if distance == 0:
                yield from ("2", terms)
            else:
                yield from ("3", f"{terms}, {control}, 1, {-distance:.12g}")


def _step(
    specimen: Specimen,
    mesh: PlanarMesh,
    parts: tuple[_Part, _Part],
    control: int,
    settings: DeckSettings,
) -> Iterator[str]:
    a, b, c = choose_nodes_under_kirigami(mesh, specimen.gravity)
    held = parts[-1].nodes(INTERFACE)
    yield "*AMPLITUDE, NAME=VANISHING"
    yield "0., 1., 1., 0."
    yield "*STEP, NLGEOM, INC=1000"
    yield "*STATIC"
    yield (
        f"{settings.first_increment:g}, 1., {settings.smallest_increment:g}, "
        f"{settings.largest_increment:g}"
    )
    yield "*BOUNDARY"
    yield from (f"{held[a]}, 1, 3", f"{held[b]}, 2, 3", f"{held[c]}, 3, 3")
    yield f"{control}, 1, 1, 1."
    if settings.imperfection:
        yield from _saddle_load(specimen, mesh, parts, settings.imperfection)
    if specimen.gravity:
        yield "*DLOAD"
        for part in parts:
            yield f"{part.name}, GRAV, {MM_PER_M * specimen.gravity:.10g}, 0., 0., -1."
    yield from ("*NODE FILE, FREQUENCY=1000000", "U", "*END STEP")


def _saddle_load(
    specimen: Specimen, mesh: PlanarMesh, parts: tuple[_Part, _Part], acceleration: float
) -> Iterator[str]:
    """Yield forces on the substrate's mass where no node is eliminated, see `SaddleLoad`."""
    eliminated, kept = (part.nodes(INTERFACE)[: len(mesh.points)] for part in parts)
    substrate = specimen.carrier
    mass = substrate.density * substrate.thickness * flat_surface(mesh).node_areas
    saddle = SaddleLoad.on_points(mesh.points, mass, specimen.characteristic_length)
    forces = mass * acceleration * saddle.at(*mesh.points.T)
    yield "*CLOAD, AMPLITUDE=VANISHING"
    for node, force in zip(np.where(kept > 0, kept, eliminated), forces, strict=True):
        yield f"{node}, 3, {force:.6e}"


def choose_nodes_under_kirigami(mesh: PlanarMesh, gravity: float) -> HeldNodes:
    """Return the held nodes, see `bilayer.specimen.support`, of those that carry kirigami.

    The substrate's nodes that do are eliminated.
    """
    carrying = np.unique(mesh.triangles[mesh.faces_of(KIRIGAMI_LAYER)])
    a, b, c = carrying[list(choose_held_nodes(mesh.points[carrying], gravity, mesh.centroid))]
    return int(a), int(b), int(c)
