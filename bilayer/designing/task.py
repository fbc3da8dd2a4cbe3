"""The design file: which specimen shall take which shape, and what may be changed for it."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from bilayer.designing.fields import has_fields, with_sharpness
from bilayer.designing.scenarios import Robustness
from bilayer.designing.targets import Target, target_from_table
from bilayer.designing.trust_region import Limits
from bilayer.designing.variables import (
    UNITS,
    Variable,
    Variables,
    is_of_the_sheet,
    kind_of,
    value_of,
    with_values,
)
from bilayer.designing.widths import LeastWidths
from bilayer.errors import InputError
from bilayer.runtime.input_file import read_text
from bilayer.solvers.registry import settings_class
from bilayer.specimen.pattern import CutPattern, SectorProfile
from bilayer.specimen.settings import CONTACT_CHOICES, settings_from, settings_to_toml
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.toml import read_specimen, specimen_to_toml
from bilayer.specimen.toml_text import parse_toml
from bilayer.specimen.units import in_si
from bilayer.validation import (
    keep,
    listed,
    nearest,
    not_negative,
    one_of,
    positive,
    shown,
    whole,
    within,
)

KEYS = ("specimen", "target", "free", "profile", "robust", "constraints", "search", "check")
CONSTRAINTS = {
    "least_web": "m", "least_slot": "m", "least_radius": "m", "least_gap": "m",
    "least_stiffness": "N/m^3",
}  # fmt: skip
OF_SHAPE = ("least_gap", "least_stiffness")
"""Constraints of the shape, not of what is cut."""
DESIGN_SOLVER = "dshell"
RADII = (Limits.least_radius, 1.0)
"""Of the first box of the search."""


@dataclass(frozen=True)
class Check:
    """How the finite-element model checks a design.

    Parameters
    ----------
    runs : int
        Most runs; 0: none. All but the last correct the shape that the shell gives.
    mesh_size : float or None
        Edge length of the last run's mesh, m; three quarters of the design's if left out.
    step : float
        Longest step of the prestretch from one milestone to the next.
    evaluations : int
        Of the search by the finite-element model itself, before the last run.
    contact : {"none", "barrier"}
        Of all runs and of the search for lower states: whether the sheet may press on itself.
    starts : int
        Of a search for lower states after the last run; 0: none.
    """

    runs: int = 0
    mesh_size: float | None = None
    step: float = 0.1
    evaluations: int = 0
    contact: str = "none"
    starts: int = 0

    def __post_init__(self) -> None:
        keep(self, whole, "runs", "evaluations", table="check.", at_least=0, at_most=100)
        keep(self, whole, "starts", table="check.", at_least=0, at_most=10_000)
        keep(self, one_of, "contact", table="check.", choices=CONTACT_CHOICES)
        for name in ("evaluations", "starts"):
            if getattr(self, name) and not self.runs:
                raise InputError(f"check.runs = 0: expected at least 1 after check.{name}")
        if self.mesh_size is not None:
            keep(self, positive, "mesh_size", table="check.", unit="m")
        keep(self, positive, "step", table="check.")


@dataclass(frozen=True, eq=False)
class DesignTask:
    """What shall be designed.

    Parameters
    ----------
    specimen : Specimen
        Where the search begins; its last milestone is the prestretch of the shape.
    target : Target
        The shape.
    variables : Variables
        What may be changed.
    robustness : Robustness
        What it shall bear.
    widths : LeastWidths
        What can be cut.
    least_gap : float
        Two places of the sheet that nearly touch shall stay so far apart, m.
    least_stiffness : float
        Of every shape against its softest deformation, N/m3, see `bilayer.designing.softness`; 0:
        any that is stable.
    sharpness : sequence of float
        Of the fields of density: the whole search is done with each in turn, from where the one
        before has ended. None: as the specimen has it.
    limits : Limits
        Of the search; evaluations of the shape at all scenarios each.
    settings : settings dataclass
        Of the shell.
    check : Check
        By the finite-element model.
    """

    specimen: Specimen
    target: Target
    variables: Variables
    robustness: Robustness = field(default_factory=Robustness)
    widths: LeastWidths = field(default_factory=LeastWidths)
    least_gap: float = 5e-4
    limits: Limits = field(default_factory=lambda: Limits(40))
    settings: Any = None
    check: Check = field(default_factory=Check)
    least_stiffness: float = 0.0
    sharpness: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        own = self.specimen.with_milestones([self.specimen.prestretch.milestones[-1]])
        object.__setattr__(self, "specimen", own)
        if own.is_placed:
            raise InputError("specimen: has a weight or loads, expected none for a design")
        if self.settings is None:
            object.__setattr__(self, "settings", settings_class(DESIGN_SOLVER)())
        keep(self, not_negative, "least_gap", unit="m")
        keep(self, not_negative, "least_stiffness", unit="N/m^3")
        sharpness = [not_negative("search.sharpness", value)
                     for value in listed("search.sharpness", self.sharpness)]  # fmt: skip
        object.__setattr__(self, "sharpness", tuple(sharpness))
        self._check_fields()
        shares = self.variables.shares_of(own)
        for variable, share in zip(self.variables.variables, shares, strict=True):
            if not 0 <= share <= 1:
                raise InputError(
                    f"free.{variable.name}: the specimen has {value_of(own, variable.name):.6g}, "
                    f"expected from {variable.low:.6g} to {variable.high:.6g}"
                )
            _check_bounds(own, variable)
        for name in self.robustness.of:
            if is_of_the_sheet(name):
                raise InputError(f"robust.of: {name!r} moves the mesh, expected others")
            value_of(own, name)
        short = self.widths.margins(own).min(initial=0.0)
        if short < 0:
            raise InputError(
                f"constraints: the specimen is {-1e3 * short * own.characteristic_length:.3g} mm "
                "short of them, expected one that begins within"
            )

    def _check_fields(self) -> None:
        if not has_fields(self.specimen):
            if self.sharpness:
                raise InputError("search.sharpness: expected none without a density-field")
        elif self.check.evaluations or self.check.runs > 1:
            raise InputError(
                "check: a density-field is cut out for the finite-element model, on another mesh; "
                "expected runs = 0 or 1, and no evaluations"
            )

    def sharpened(self) -> Iterator["DesignTask"]:
        """Yield the tasks of the search one by one: with each sharpness, or this one alone."""
        for sharpness in self.sharpness:
            yield replace(self, specimen=with_sharpness(self.specimen, sharpness))
        if not self.sharpness:
            yield self

    @property
    def identity(self) -> str:
        """A text that two tasks share if they are the same."""
        parts = [
            specimen_to_toml(self.specimen),
            settings_to_toml(self.settings),
            repr(self.variables), repr(self.robustness), repr(self.widths), repr(self.least_gap),
            repr(self.limits), self.target.identity,
        ]  # fmt: skip
        if self.least_stiffness:  # folders of before knew none
            parts.append(f"least_stiffness={self.least_stiffness!r}")
        if self.sharpness:
            parts.append(f"sharpness={self.sharpness!r}")
        return sha256(json.dumps(parts).encode()).hexdigest()[:16]


def _check_bounds(specimen: Specimen, variable: Variable) -> None:
    """Raise InputError if a variable cannot have one of its bounds, all else as it is.

    Those of the sheet depend on each other; of them a negative one is refused.
    """
    name = variable.name
    if is_of_the_sheet(name):
        not_negative(f"free.{name}: from", variable.low)
        return
    for bound in (variable.low, variable.high):
        try:
            with_values(specimen, {name: bound})
        except InputError as error:
            raise InputError(f"free.{name}: {bound:g} is out of its range ({error})") from error


def read_design(path: str | Path) -> DesignTask:
    r"""Read a design file.

    Parameters
    ----------
    path : path-like
        TOML; the files that it names lie beside it. See docs/design.md.

    Raises
    ------
    InputError
        It cannot be read, a key is unknown, or a value is out of its range.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import bilayer
    >>> folder = Path(tempfile.mkdtemp())
    >>> sheet = bilayer.specimen_to_toml(bilayer.paper_specimen())
    >>> _ = (folder / "sheet.toml").write_text(sheet)
    >>> _ = (folder / "design.toml").write_text(
    ...     'specimen = "sheet.toml"\n'
    ...     'target = { shape = "cap", angle = "60 deg" }\n'
    ...     'free = { "kirigami.thickness" = ["0.5 mm", "3 mm"] }\n'
    ... )
    >>> bilayer.read_design(folder / "design.toml").variables.names
    ('kirigami.thickness',)
    """
    tables = _tables(Path(path))
    folder = Path(path).parent
    name = tables.get("specimen")
    if not isinstance(name, str):
        raise InputError(f"design file {path}: specimen = {shown(name)}: expected a file name")
    specimen = read_specimen(folder / name)
    if "profile" in tables:
        specimen = with_profile(specimen, **_known("profile", tables["profile"], ("knots",)))
    constraints = in_si("constraints", _known("constraints", tables.get("constraints", {}),
                                              CONSTRAINTS), CONSTRAINTS)  # fmt: skip
    of_shape = {name: constraints.pop(name) for name in OF_SHAPE if name in constraints}
    search = dict(_table("search", tables.get("search", {})))
    sharpness = search.pop("sharpness", ())
    settings: Any = settings_from(
        settings_class(DESIGN_SOLVER), _table("search.settings", search.pop("settings", {}))
    )
    check = in_si(
        "check",
        _known("check", tables.get("check", {}), [each.name for each in fields(Check)]),
        {"mesh_size": "m"},
    )
    return DesignTask(
        specimen,
        target_from_table(_table("target", tables.get("target")), folder, specimen),
        _variables(specimen, _table("free", tables.get("free"))),
        Robustness(**_known("robust", tables.get("robust", {}), ("spread", "of", "minimise"))),
        LeastWidths(**constraints),
        limits=_limits(search),
        settings=settings,
        check=Check(**check),
        sharpness=sharpness,
        **of_shape,
    )


def with_profile(specimen: Specimen, knots: int = 5) -> Specimen:
    """Return a specimen whose equal sectors are a profile of some knots, of the same shape.

    The knots lie at equal distances from the inner radius to the rim.
    """
    count = whole("profile.knots", knots, at_least=2, at_most=100)
    reach = float(np.linalg.norm(np.array(specimen.outline.polygon.exterior.coords), axis=1).max())
    layers = tuple(
        replace(layer, pattern=_profile_of(layer.pattern, count, reach))
        if isinstance(layer.pattern, CutPattern)
        else layer
        for layer in specimen.layers
    )
    return replace(specimen, layers=layers)


def _profile_of(cut: CutPattern, knots: int, reach: float) -> SectorProfile:
    radii = tuple(float(r) for r in np.linspace(cut.inner_radius, reach, knots))
    return SectorProfile(cut.strips, radii, (cut.cutout_angle / 2,) * knots)


def _variables(specimen: Specimen, table: Mapping[str, Any]) -> Variables:
    """Return the variables of the table [free]; a list of a pattern stands for all its numbers."""
    found = []
    for name, bounds in table.items():
        pair = in_si("free", {name: bounds}, {name: UNITS.get(kind_of(name), "")})[name]
        if not isinstance(pair, list) or len(pair) != 2:
            raise InputError(f"free.{name} = {shown(bounds)}: expected [from, to]")
        found += [Variable(own, *pair) for own in _numbers_named(specimen, name)]
    return Variables(tuple(found))


def _numbers_named(specimen: Specimen, name: str) -> list[str]:
    parts = name.split(".")
    if len(parts) == 2 and parts[1] == "share" and parts[0] in specimen.layer_names:
        shares = getattr(specimen.layer(parts[0]).pattern, "share", ())
        return [f"{name}.{place}" for place in range(len(shares))] or [name]
    if len(parts) == 3 and parts[1] == "pattern" and parts[0] in specimen.layer_names:
        values = getattr(specimen.layer(parts[0]).pattern, parts[2], None)
        if isinstance(values, tuple):
            return [f"{name}.{place}" for place in range(len(values))]
    value_of(specimen, name)
    return [name]


def _limits(table: Mapping[str, Any]) -> Limits:
    _known("search", table, ("evaluations", "radius"))
    count = whole("search.evaluations", table.get("evaluations", 40), at_least=1, at_most=10_000)
    radius = within("search.radius", table.get("radius", Limits.radius), *RADII)
    return Limits(count, radius)


def _tables(path: Path) -> dict[str, Any]:
    tables = parse_toml(read_text(path, "design file"), f"design file {path}")
    for key in tables:
        if key not in KEYS:
            expected = f"expected one of {', '.join(KEYS)}"
            raise InputError(f"design file {path}: {key}: unknown, {expected}{nearest(key, KEYS)}")
    return tables


def _table(name: str, given: Any) -> Mapping[str, Any]:
    if not isinstance(given, Mapping):
        raise InputError(f"{name} = {shown(given)}: expected a table [{name}]")
    return given


def _known(name: str, given: Any, keys: Any) -> dict[str, Any]:
    table = _table(name, given)
    for key in table:
        if key not in keys:
            expected = f"expected one of {', '.join(keys)}"
            raise InputError(f"{name}.{key}: unknown, {expected}{nearest(key, list(keys))}")
    return dict(table)
