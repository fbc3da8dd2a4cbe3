"""The specimen: a flat sheet of bonded layers, and the prestretches at which its shape is wanted.

`Specimen.bonded_layers` says what lies where when it is bonded, and how far that is from the
natural state of each layer: that is all a solver needs. Everything is in SI units and checked when
it is made.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate
from typing import Any

import shapely

from bilayer.errors import InputError, fields_of
from bilayer.specimen.density_field import DensityField
from bilayer.specimen.layer import BondedLayer, Layer
from bilayer.specimen.load import FREE, Load, Milestone
from bilayer.specimen.load_checks import check_loads, check_places
from bilayer.specimen.obstacle import Obstacle, PlaneObstacle
from bilayer.specimen.outline import Disc, Outline
from bilayer.specimen.pattern import kept_share
from bilayer.specimen.prestretch import Prestretch, StretchPair
from bilayer.specimen.reference_surface import ReferenceSurface
from bilayer.specimen.schedule import Schedule
from bilayer.specimen.supported import Support
from bilayer.validation import keep, listed, nearest, not_negative, positive, text

SUBSTRATE, KIRIGAMI_LAYER = "substrate", "kirigami"
"""Names of the layers that a bilayer has: the one that holds it together, the one that is cut."""
LARGEST_GRAVITY = 1e6
"""As in the fastest centrifuges, m/s2; a shape under more is sought in vain, for minutes."""
MOST_LAYERS = 12
"""So that the sets of layers, of which there are two to that power, can be numbered."""


@dataclass(frozen=True)
class MeshSize:
    """Edge lengths asked of the planar mesh.

    Parameters
    ----------
    size : float
        Edge length, m.
    corner_size : float or None
        Edge length at the corners of the cuts, m; None: `size` everywhere.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> coarse = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.006))
    """

    size: float = 0.003
    corner_size: float | None = None

    def __post_init__(self) -> None:
        keep(self, positive, "size", table="mesh.", unit="m")
        if self.corner_size is not None:
            keep(self, positive, "corner_size", table="mesh.", unit="m")
            if self.corner_size > self.size:
                raise InputError(
                    f"mesh.corner_size = {self.corner_size} m: expected at most "
                    f"mesh.size = {self.size} m"
                )


@dataclass(frozen=True)
class Specimen:
    """A flat sheet of layers, and the prestretches at which its shape is wanted.

    Parameters
    ----------
    outline : Outline
        Of the sheet.
    layers : sequence of Layer
        From the bottom up; each has a name of its own.
    prestretch : Prestretch
        The milestones.
    mesh : MeshSize
        Edge lengths of the planar mesh.
    gravity : float
        Acceleration of the true weight along -z, m/s2.
    name : str
        A label for figures and files.
    supports : sequence of Support
        Parts that are held.
    loads : sequence of Load
        With a value at each milestone. If they have more values than there are prestretches, the
        single prestretch holds at all of them.
    schedule : Schedule or None
        Milestones of time at the single prestretch; None: each layer answers at once.
    obstacles : sequence of Obstacle
        Rigid and at rest; the sheet cannot pass through them.

    Examples
    --------
    >>> import bilayer
    >>> soft, stiff = bilayer.NeoHookean(c10=20e3), bilayer.NeoHookean(c10=60e3)
    >>> specimen = bilayer.Specimen(
    ...     bilayer.Rectangle(0.04, 0.03),
    ...     [
    ...         bilayer.Layer("substrate", 1e-3, soft, response=bilayer.Response("path")),
    ...         bilayer.Layer("kirigami", 1e-3, stiff, pattern=bilayer.Cross(arm_width=0.004)),
    ...     ],
    ...     bilayer.Prestretch([1.03, 1.06]),
    ... )
    >>> specimen.layer_names
    ('substrate', 'kirigami')
    """

    outline: Outline
    layers: tuple[Layer, ...]
    prestretch: Prestretch
    mesh: MeshSize = MeshSize()
    gravity: float = 0.0
    name: str = "specimen"
    supports: tuple[Support, ...] = ()
    loads: tuple[Load, ...] = ()
    schedule: Schedule | None = None
    obstacles: tuple[Obstacle, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "prestretch", _at_every_time(self.prestretch, self.schedule))
        object.__setattr__(self, "layers", _checked_layers(self.layers))
        object.__setattr__(self, "supports", tuple(self.supports))
        object.__setattr__(self, "obstacles", tuple(self.obstacles))
        object.__setattr__(self, "loads", _checked_loads(self.loads))
        object.__setattr__(self, "prestretch", _at_every_load(self.prestretch, self.loads))
        gravity = not_negative("gravity.acceleration", self.gravity, "m/s2")
        if gravity > LARGEST_GRAVITY:
            raise InputError(
                f"gravity.acceleration = {gravity:g} m/s2: expected at most {LARGEST_GRAVITY:g}"
            )
        object.__setattr__(self, "gravity", gravity)
        _check_laid(self.obstacles, gravity)
        keep(self, text, "name", table="specimen.")
        for layer in self.layers:
            if layer.pattern is not None:
                with fields_of(f"layers.{layer.name}.pattern"):
                    layer.pattern.check_fit(self.outline)
        if self.mesh.size > self.characteristic_length:
            raise InputError(
                f"mesh.size = {self.mesh.size} m: expected at most {self.length_text} (a bare "
                "number is in m, millimetres as '8 mm')"
            )
        for layer in self.layers:
            for milestone in self.prestretch.milestones:
                layer.response.axial(milestone)
        check_places(self.supports, self.loads, self.outline)
        check_loads(self.loads, self.layers, self.characteristic_length)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: a drawing, and the layers with their units."""
        from bilayer.specimen.html import specimen_html  # few need it

        return specimen_html(self)

    @property
    def milestones(self) -> tuple[Milestone, ...]:
        """The states of the path: at each the two stretches, then the value of each load."""
        return tuple(
            (x, y, *(load.at(number) for load in self.loads))
            for number, (x, y) in enumerate(self.prestretch.milestones)
        )

    @property
    def is_placed(self) -> bool:
        """Whether something outside holds the sheet where it is, so that its shape has a place."""
        return self.gravity > 0 or bool(self.supports or self.loads or self.obstacles)

    @property
    def is_laid(self) -> bool:
        """Whether it lies on a table by its weight, free to slide, to turn and to rise."""
        return any(_is_table(obstacle) for obstacle in self.obstacles)

    @property
    def drawn_lines(self) -> tuple[shapely.LineString, ...]:
        """The lines of supports and loads, along which the planar mesh gets edges, m."""
        parts = [support.part for support in self.supports] + [load.part for load in self.loads]
        lines = (part.drawn for part in parts)
        return tuple(line for line in lines if line is not None)

    @property
    def characteristic_length(self) -> float:
        """Radius of the circle of the outline's area, m; of a disc its radius."""
        return self.outline.characteristic_length

    @property
    def length_text(self) -> str:
        """The characteristic length in the words of a message."""
        if isinstance(self.outline, Disc):
            return f"specimen.outer_radius = {self.outline.radius} m"
        shape = type(self.outline).__name__
        return f"a {shape} of the characteristic length {self.characteristic_length:.6g} m"

    @property
    def sheet(self) -> shapely.Geometry:
        """The part of the outline where any layer lies, m."""
        return shapely.union_all([self.region_of(name) for name in self.layer_names])

    @property
    def layer_names(self) -> tuple[str, ...]:
        """Names of the layers, from the bottom up."""
        return tuple(layer.name for layer in self.layers)

    @cached_property
    def carrier(self) -> Layer:
        """The layer that holds the sheet together.

        Of the whole layers (or, without one, of those that cover most) one named "substrate", or
        else the first from below that is stretched, or else the first.
        """
        whole = [layer for layer in self.layers if layer.is_whole]
        if not whole:
            shares = [kept_share(layer.pattern, self.outline) for layer in self.layers]
            most = zip(self.layers, shares, strict=True)
            whole = [layer for layer, share in most if share == max(shares)]
        return max(whole, key=lambda layer: (layer.name == SUBSTRATE, layer.is_stretched))

    @property
    def reference_surface(self) -> ReferenceSurface:
        """The surface that the `position` of a result is.

        The bond of two layers, else the mid-surface of the carrier.
        """
        if len(self.layers) == 2:
            return ReferenceSurface(self.layers[0].name, 1.0)
        return ReferenceSurface(self.carrier.name, 0.5)

    @property
    def stretched_layers(self) -> tuple[str, ...]:
        """Names of the layers that the prestretch does something to, from the bottom up."""
        return tuple(layer.name for layer in self.layers if layer.is_stretched)

    @cached_property
    def layer_sets(self) -> tuple[frozenset[str], ...]:
        """The layers that lie there, for each number of a region.

        A bit of the number stands for each layer but a whole carrier, the lowest for the lowest: a
        bilayer has 0 where the substrate is bare and 1 where the kirigami lies on it.
        """
        always = {self.carrier.name} if self.carrier.is_whole else set()
        others = [name for name in self.layer_names if name not in always]
        return tuple(
            frozenset(always | {name for bit, name in enumerate(others) if number >> bit & 1})
            for number in range(2 ** len(others))
        )

    @property
    def flat_identity(self) -> list[str]:
        """Texts that specimens share which have the same planar mesh."""
        patterns = [
            f"{layer.name}: {layer.pattern.identity if layer.pattern else 'whole'}"
            for layer in self.layers
        ]
        drawn = [line.wkt for line in self.drawn_lines]
        return [self.outline.identity, *patterns, repr(self.mesh), *drawn]

    def layer(self, name: str) -> Layer:
        """Return a layer by its name."""
        for layer in self.layers:
            if layer.name == name:
                return layer
        expected = f"expected one of {', '.join(self.layer_names)}"
        raise InputError(f"layer = {name!r}: {expected}{nearest(name, self.layer_names)}")

    def region_of(self, name: str) -> shapely.Geometry:
        """Return the part of the sheet where a layer lies, m."""
        pattern = self.layer(name).pattern
        return self.outline.polygon if pattern is None else pattern.kept(self.outline)

    def bonded_layers(self, stretch: StretchPair) -> tuple[BondedLayer, ...]:
        """Return the layers in the flat bonded state, from the bottom up.

        Parameters
        ----------
        stretch : (float, float)
            (lambda_x, lambda_y) of the path.

        Returns
        -------
        tuple of BondedLayer
            Their heights are measured from the reference surface at that stretch.
        """
        stretches = [layer.response.tensor(stretch) for layer in self.layers]
        thickness = [
            layer.thickness / self._thinning(tensor)
            for layer, tensor in zip(self.layers, stretches, strict=True)
        ]
        levels = self._levels(thickness)
        return tuple(
            BondedLayer(layer.name, layer, bottom, top, tensor)
            for layer, tensor, bottom, top in zip(
                self.layers, stretches, levels, levels[1:], strict=False
            )
        )

    def bonded_layer(self, name: str, stretch: StretchPair) -> BondedLayer:
        """Return one layer, by its name, in the flat bonded state; see `bonded_layers`."""
        number = self.layers.index(self.layer(name))
        return self.bonded_layers(stretch)[number]

    def with_layer(self, name: str, /, **changes: Any) -> "Specimen":
        """Return the same specimen with some fields of one layer changed."""
        changed = self.layer(name)
        layers = [replace(layer, **changes) if layer is changed else layer for layer in self.layers]
        return replace(self, layers=tuple(layers))

    def with_milestones(self, milestones: Sequence[float | StretchPair]) -> "Specimen":
        """Return the same specimen with other prestretches; loads keep their values."""
        schedule = self.schedule if self.schedule is None else self.schedule.first(len(milestones))
        prestretch = replace(self.prestretch, milestones=milestones)  # type: ignore[arg-type]
        return replace(self, prestretch=prestretch, schedule=schedule)

    def at_milestone(self, milestone: Milestone) -> "Specimen":
        """Return the same specimen with a single milestone, loads included."""
        x, y, *values = milestone
        loads = [
            replace(load, values=(FREE if math.isnan(value) else value,))
            for load, value in zip(self.loads, values, strict=True)
        ]
        single = replace(self.prestretch, milestones=((x, y),))
        return replace(self, prestretch=single, loads=tuple(loads))

    def _thinning(self, tensor: Any) -> float:
        """Return the natural thickness over the bonded one."""
        if self.prestretch.thickness == "constant":
            return 1.0
        (a, b), (_, c) = tensor
        return float(a * c - b * b)

    def _levels(self, thickness: Sequence[float]) -> list[float]:
        """Return the heights of all interfaces, outer sides among them, from the bottom up, m."""
        reference = self.reference_surface
        number = self.layer_names.index(reference.layer)
        bottom = -reference.share * thickness[number]
        top = (1.0 - reference.share) * thickness[number]
        below = accumulate([bottom, *(-t for t in thickness[:number][::-1])])
        above = accumulate([top, *thickness[number + 1 :]])
        return [*[*below][::-1], *above]


def refuse_loading(specimen: Specimen, whom: str) -> None:
    """Raise InputError if a specimen has supports or loads, which somebody does not know."""
    for table, parts in (("supports", specimen.supports), ("loads", specimen.loads)):
        if parts:
            raise InputError(f"[{table}.{parts[0].name}]: {whom} has no {table}, expected none")


def refuse_obstacles(specimen: Specimen, whom: str) -> None:
    """Raise InputError if a specimen has obstacles, which somebody does not know."""
    if specimen.obstacles:
        name = specimen.obstacles[0].name
        raise InputError(f"[obstacles.{name}]: {whom} has no obstacles, expected none")


def _is_table(obstacle: Obstacle) -> bool:
    """Whether the flat sheet lies on an obstacle."""
    return isinstance(obstacle, PlaneObstacle) and obstacle.point is None


def _check_laid(obstacles: Sequence[Obstacle], gravity: float) -> None:
    """Raise InputError if the sheet is to lie on more than one plane, or has no weight for it."""
    tables = [obstacle for obstacle in obstacles if _is_table(obstacle)]
    if len(tables) > 1:
        raise InputError(f"obstacles.{tables[1].name}.point: missing, the sheet lies on another")
    if tables and gravity == 0:
        raise InputError(
            f"obstacles.{tables[0].name}: the sheet lies on it by its weight, expected "
            "gravity.acceleration, or a point of the plane"
        )


def _checked_loads(given: Any) -> tuple[Load, ...]:
    """Return the loads, whose values are all single ones or as many as the others'."""
    loads = tuple(given)
    counts = {len(load.values): load for load in loads if len(load.values) > 1}
    if len(counts) > 1:
        (few, one), (many, other), *_ = sorted(counts.items())
        raise InputError(
            f"loads.{one.name}.{one.kind}: has {few} values and loads.{other.name}.{other.kind} "
            f"{many}, expected as many, or a single one"
        )
    return loads


def _at_every_load(prestretch: Prestretch, loads: Sequence[Load]) -> Prestretch:
    """Return a prestretch with a milestone for each value of the loads."""
    count = max((len(load.values) for load in loads), default=1)
    given = len(prestretch.milestones)
    if count in (1, given):
        return prestretch
    if given != 1:
        load = next(load for load in loads if len(load.values) == count)
        raise InputError(
            f"prestretch.milestones: has {given} values and loads.{load.name}.{load.kind} {count}, "
            "expected as many, or a single one"
        )
    return replace(prestretch, milestones=prestretch.milestones * count)


def refuse_time(specimen: Specimen, whom: str) -> None:
    """Raise InputError if a specimen has milestones of time, which somebody does not know."""
    if specimen.schedule is not None:
        raise InputError(f"[time]: {whom} takes no steps of time, expected none")


def refuse_fields(specimen: Specimen, whom: str) -> None:
    """Raise InputError if a layer has a field of density, which somebody does not know."""
    for layer in specimen.layers:
        if isinstance(layer.pattern, DensityField):
            raise InputError(
                f"layers.{layer.name}.pattern: is a density-field, which is for the shell morley "
                f"and not for {whom}; expected the pattern that is cut out of it"
            )


def _at_every_time(prestretch: Prestretch, schedule: Schedule | None) -> Prestretch:
    """Return a prestretch with a milestone for each time."""
    if schedule is None:
        return prestretch
    given, count = prestretch.milestones, len(schedule.milestones)
    if len(set(given)) > 1 or len(given) not in (1, count):
        raise InputError(
            f"prestretch.milestones: has {len(given)} values, expected a single one, which holds "
            "at all milestones of [time]"
        )
    return replace(prestretch, milestones=given[:1] * count)


def _checked_layers(layers: Any) -> tuple[Layer, ...]:
    given = tuple(listed("layers", layers))
    if not 1 <= len(given) <= MOST_LAYERS:
        raise InputError(f"layers: there are {len(given)}, expected from 1 to {MOST_LAYERS}")
    for layer in given:
        if not isinstance(layer, Layer):
            raise InputError(f"layers: {layer!r} is among them, expected objects of Layer")
    names = [layer.name for layer in given]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise InputError(f"layers: {twice[0]!r} is the name of two, expected one of its own each")
    return given
