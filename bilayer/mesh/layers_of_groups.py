"""Which layers lie on the triangles of a file of gmsh, by the physical groups that they are in.

A group is named after its layer, "kirigami", or its layers, "film+kirigami". The layers that lie
everywhere need no group. A triangle may be in several groups. "bare" is the layers that lie
everywhere alone. Groups without a name tell by their tag, the number of the region. A group that
holds all triangles and is no layer's says nothing.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.gmsh_files import PhysicalGroups
from bilayer.validation import nearest

if TYPE_CHECKING:
    import meshio

BARE = "bare"
JOINED = "+"

MOST_SHOWN = 4
"""Regions that a message lists."""

Layers = frozenset[str]
Tags = frozenset[int]


def region_by_groups(
    groups: PhysicalGroups, layer_sets: Sequence[Layers]
) -> NDArray[np.int64] | None:
    """Return the region of each triangle, shape (m,); None if the groups do not divide the sheet.

    Parameters
    ----------
    groups : PhysicalGroups
        Of the triangles.
    layer_sets : sequence of frozenset of str
        The layers of each region, see `bilayer.specimen.specimen.Specimen.layer_sets`.

    Raises
    ------
    InputError
        A group is no layer's, or some triangles are in none where that can mean two things.
    """
    names = _LayerNames(layer_sets)
    _check_named_are_used(groups, names)
    everywhere = frozenset.intersection(*groups.sets) if groups.sets else frozenset()
    silent = {tag for tag in everywhere if not names.are_layers(groups.names.get(tag))}
    dividing = [tags - silent for tags in groups.sets]
    if not any(dividing):
        return None
    has_names = any(tag in groups.names for tags in dividing for tag in tags)
    region = _by_names(groups, dividing, names) if has_names else _by_tags(dividing, names)
    return np.array(region)[groups.number]


def groups_of_sets(data: "meshio.Mesh", layer_sets: Sequence[Layers]) -> PhysicalGroups | None:
    """Return the sets of triangles of a file that are named after layers, as groups.

    Parameters
    ----------
    data : meshio.Mesh
        Of a format with named sets, as Abaqus'.
    layer_sets : sequence of frozenset of str
        The layers of each region.

    Returns
    -------
    PhysicalGroups or None
        None if there is no such set; others say nothing of layers.
    """
    names = _LayerNames(layer_sets)
    sets = {
        name: members["triangle"]
        for name, members in data.cell_sets_dict.items()
        if names.are_layers(name) and len(members.get("triangle", ()))
    }
    if not sets:
        return None
    is_in = np.zeros((len(data.get_cells_type("triangle")), len(sets)), dtype=bool)
    for column, members in enumerate(sets.values()):
        is_in[members, column] = True
    rows, number = np.unique(is_in, axis=0, return_inverse=True)
    tags = np.arange(1, len(sets) + 1)
    return PhysicalGroups(
        dict(zip(tags.tolist(), sets, strict=True)),
        tuple(frozenset(tags[row].tolist()) for row in rows),
        number.reshape(-1),
    )


def name_of_layers(layers: Layers) -> str:
    """Return the name of the group of triangles on which some layers lie."""
    return JOINED.join(sorted(layers))


class _LayerNames:
    """The names that groups can have, and what they stand for."""

    def __init__(self, layer_sets: Sequence[Layers]) -> None:
        self.sets = list(layer_sets)
        filled = [layers for layers in self.sets if layers]
        self.everywhere: Layers = frozenset.intersection(*filled)
        self.all: Layers = frozenset.union(*filled)
        self._by_lower = {name.lower(): frozenset({name}) for name in sorted(self.all)}
        if self.everywhere:
            self._by_lower.setdefault(BARE, frozenset())

    @property
    def text(self) -> str:
        """What is expected, for messages."""
        known = ", ".join(sorted(self.all))
        bare = f", or {BARE}" if self.everywhere else ""
        return f"the name of a layer ({known}), or several joined by {JOINED}{bare}"

    def are_layers(self, name: str | None) -> bool:
        """Whether a name is of layers."""
        return name is not None and all(part in self._by_lower for part in self._parts(name))

    def layers(self, name: str) -> Layers:
        """Return the layers that a name stands for, those everywhere among them."""
        if not self.are_layers(name):
            known = nearest(name, [*self.all, BARE])
            raise InputError(f"its physical group {name!r}: expected {self.text}{known}")
        return self.everywhere.union(*(self._by_lower[part] for part in self._parts(name)))

    def region(self, layers: Layers) -> int:
        """Return the number of the region of some layers."""
        return self.sets.index(layers)

    @staticmethod
    def _parts(name: str) -> list[str]:
        return [part.strip().lower() for part in name.split(JOINED)]


def _check_named_are_used(groups: PhysicalGroups, names: _LayerNames) -> None:
    """Raise InputError if there are names of layers or parts, but no triangle is in any group."""
    is_divided = len(groups.names) > 1 or any(map(names.are_layers, groups.names.values()))
    if is_divided and not any(groups.sets):
        listed = ", ".join(map(repr, groups.names.values()))
        raise InputError(
            f"no triangle is in a physical group, though it names {listed}: gmsh's version 2.2 "
            "with Mesh.SaveAll leaves out the groups, expected it without, or version 4.1"
        )


def _by_names(groups: PhysicalGroups, dividing: list[Tags], names: _LayerNames) -> list[int]:
    """Return the region of each set of groups, some of which have a name."""
    named = [
        names.everywhere.union(*(names.layers(groups.names.get(tag, str(tag))) for tag in tags))
        for tags in dividing
    ]
    found = {layers for layers, tags in zip(named, dividing, strict=True) if tags}
    if all(dividing):
        rest = names.everywhere  # of none
    elif found == {names.everywhere}:
        rest = names.all
    elif names.everywhere and names.everywhere not in found:
        rest = names.everywhere
    else:
        raise InputError(
            f"{groups.ungrouped} of its {len(groups.number)} triangles are in no physical group, "
            f"expected each in one that is {names.text}"
        )
    layers = [there if tags else rest for there, tags in zip(named, dividing, strict=True)]
    return [names.region(there) for there in layers]


def _by_tags(dividing: list[Tags], names: _LayerNames) -> list[int]:
    """Return the region of each set of groups without names: the tag of its only one."""
    regions = [max(tags, default=0) for tags in dividing]
    known = [number for number, layers in enumerate(names.sets) if layers]
    if not set(regions) <= set(known) or any(len(tags) > 1 for tags in dividing):
        found = ", ".join(str(tag) for tag in sorted(frozenset.union(*dividing)))
        listed = [f"{number} ({name_of_layers(names.sets[number])})" for number in known]
        shown = listed if len(listed) <= MOST_SHOWN else [*listed[:MOST_SHOWN], "..."]
        raise InputError(
            f"its physical groups {found} have no names, expected {names.text}; or as tags "
            f"{', '.join(shown)}"
        )
    return regions
