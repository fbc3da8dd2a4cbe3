"""A bilayer: a whole substrate and a kirigami layer that may be cut, the one on the other.

It is what the paper has, what `[cut] [substrate] [kirigami]` describe in a specimen file, and all
that models made for two layers take.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from bilayer.errors import InputError
from bilayer.specimen.layer import Layer, Response
from bilayer.specimen.outline import Disc
from bilayer.specimen.pattern import CutPattern
from bilayer.specimen.prestretch import Prestretch
from bilayer.specimen.specimen import KIRIGAMI_LAYER, SUBSTRATE, MeshSize, Specimen
from bilayer.validation import listed, one_of

LAYERS = (SUBSTRATE, KIRIGAMI_LAYER)
KIRIGAMI_SIDES = ("above", "below")
BARE, KIRIGAMI = 0, 1
"""Regions of the sheet: where the kirigami layer is cut out, and where it lies."""
TWO_LAYERS = (frozenset({SUBSTRATE}), frozenset(LAYERS))
"""The layers in these regions, see `Specimen.layer_sets`."""


@dataclass(frozen=True)
class TwoLayers:
    """The two layers of a bilayer by what they are.

    Parameters
    ----------
    substrate, kirigami : Layer
        The whole one and the one that may be cut.
    kirigami_side : {"above", "below"}
        Where the kirigami layer lies, seen from the substrate.
    """

    substrate: Layer
    kirigami: Layer
    kirigami_side: str

    @classmethod
    def of(cls, specimen: Specimen, what: str) -> "TwoLayers":
        """Return the two layers of a specimen.

        Parameters
        ----------
        specimen : Specimen
            Its layers may be stretched along x and y, not along other axes.
        what : str
            Takes two layers alone, for the message: "model = 'hinge'".

        Raises
        ------
        InputError
            The specimen has other layers.
        """
        names = specimen.layer_names
        if set(names) != set(LAYERS):
            raise InputError(
                f"{what}: takes two layers named {SUBSTRATE} and {KIRIGAMI_LAYER}, this specimen "
                f"has {len(names)}: {', '.join(names)}"
            )
        substrate, kirigami = (specimen.layer(name) for name in LAYERS)
        if not substrate.is_whole:
            raise InputError(
                f"{what}: takes a whole substrate, expected layers.{SUBSTRATE} without a pattern"
            )
        for layer in specimen.layers:
            if not layer.response.is_along_axes:
                raise InputError(
                    f"{what}: takes layers that are stretched along x and y, expected "
                    f"layers.{layer.name} with angle = 0 instead of {layer.response.angle} rad"
                )
        return cls(substrate, kirigami, KIRIGAMI_SIDES[0] if names == LAYERS else KIRIGAMI_SIDES[1])

    @property
    def follow_the_path(self) -> bool:
        """Whether each layer is either stretched as the path says or not at all."""
        return all(
            layer.response in (Response(), Response("path"))
            for layer in (self.substrate, self.kirigami)
        )

    @property
    def stretched(self) -> tuple[str, ...]:
        """Names of the layers that are stretched."""
        pair = (self.substrate, self.kirigami)
        return tuple(layer.name for layer in pair if layer.is_stretched)


def disc_bilayer(
    outer_radius: float,
    substrate: Layer,
    kirigami: Layer,
    prestretch: Prestretch,
    cut: CutPattern | None = None,
    mesh: MeshSize | None = None,
    gravity: float = 0.0,
    name: str = "specimen",
    kirigami_side: str = "above",
    stretched: Sequence[str] = (SUBSTRATE,),
) -> Specimen:
    """Return the specimen of a flat disc of two layers.

    Parameters
    ----------
    outer_radius : float
        Radius of the bonded disc, m.
    substrate, kirigami : Layer
        Thickness, material and density of the whole layer and of the one that may be cut; they get
        these names.
    prestretch : Prestretch
        The milestones.
    cut : CutPattern or None
        What is cut out of the kirigami layer; None leaves it whole.
    mesh : MeshSize, optional
        Edge lengths of the planar mesh.
    gravity : float
        Acceleration of the true weight along -z, m/s2.
    name : str
        A label for figures and files.
    kirigami_side : {"above", "below"}
        Where the kirigami layer lies, seen from the substrate.
    stretched : sequence of {"substrate", "kirigami"}
        Which layers take the prestretch, one or both.

    Examples
    --------
    >>> import bilayer
    >>> soft, stiff = bilayer.NeoHookean(c10=20e3), bilayer.NeoHookean(c10=60e3)
    >>> specimen = bilayer.disc_bilayer(
    ...     0.04,
    ...     bilayer.Layer("substrate", 1e-3, soft),
    ...     bilayer.Layer("kirigami", 1e-3, stiff),
    ...     bilayer.Prestretch([1.03]),
    ...     cut=bilayer.CutPattern(5, 0.008, 0.3),
    ... )
    >>> specimen.stretched_layers
    ('substrate',)
    """
    names = stretched_layers(stretched)
    responses = {name: Response("path") if name in names else Response() for name in LAYERS}
    layers = (
        replace(substrate, name=SUBSTRATE, pattern=None, response=responses[SUBSTRATE]),
        replace(kirigami, name=KIRIGAMI_LAYER, pattern=cut, response=responses[KIRIGAMI_LAYER]),
    )
    if one_of("kirigami.side", kirigami_side, KIRIGAMI_SIDES) == "below":
        layers = layers[::-1]
    size = MeshSize() if mesh is None else mesh
    return Specimen(Disc(outer_radius), layers, prestretch, size, gravity, name)


def turned_over(specimen: Specimen) -> Specimen:
    """Return the same specimen with its layers in the opposite order."""
    return replace(specimen, layers=specimen.layers[::-1])


def with_stretched(specimen: Specimen, names: Sequence[str]) -> Specimen:
    """Return the same bilayer with the layers of these names stretched by the path, no other."""
    chosen = stretched_layers(names)
    for name in LAYERS:
        response = Response("path") if name in chosen else Response()
        specimen = specimen.with_layer(name, response=response)
    return specimen


def stretched_layers(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the layers that are stretched, in the order of `LAYERS`."""
    field = "prestretch.layers"
    given = [one_of(field, name, LAYERS) for name in listed(field, names)]
    if not given or len(set(given)) < len(given):
        raise InputError(f"{field} = {given}: expected one or both, each once")
    return tuple(name for name in LAYERS if name in given)
