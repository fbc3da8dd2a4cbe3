"""Checks that both forms of a specimen file share: known keys, required keys."""

from collections.abc import Iterable, Mapping
from typing import Any

from bilayer.errors import InputError
from bilayer.specimen.loading_tables import loads_from, loads_to, supports_from, supports_to
from bilayer.specimen.obstacle_tables import obstacles_from, obstacles_to
from bilayer.specimen.prestretch import Prestretch
from bilayer.specimen.specimen import MeshSize, Specimen
from bilayer.specimen.units import in_si
from bilayer.validation import nearest

Tables = Mapping[str, Any]

COMMON: dict[str, tuple[str, ...]] = {
    "specimen": ("name", "outer_radius"),
    "prestretch": ("milestones", "thickness"),
    "gravity": ("acceleration",),
    "mesh": ("size", "corner_size"),
    "supports": (),
    "loads": (),
    "obstacles": (),
}
"""Tables that are the same in both forms, each with its keys; those without hold tables."""


def check_keys(table: str, content: Iterable[str], known: Iterable[str]) -> None:
    """Raise InputError, with the nearest one, for a key of a table that is unknown."""
    names = list(known)
    for key in content:
        if key not in names:
            expected = f"expected one of {', '.join(names)}"
            raise InputError(f"{table}.{key}: unknown key, {expected}{nearest(key, names)}")


def required(table: str, content: Any, key: str) -> Any:
    """Return the value of a key; raise InputError if it is not there."""
    if key not in content:
        raise InputError(f"{table}.{key}: missing, expected a value in table [{table}]")
    return content[key]


def as_table(name: str, content: Any) -> Mapping[str, Any]:
    """Return a table; raise InputError if it is something else."""
    if not isinstance(content, Mapping):
        raise InputError(f"{name} = {content!r}: expected a table [{name}]")
    return content


def common_fields(data: Tables) -> dict[str, Any]:
    """Return the fields of a specimen that stand in `COMMON`, but for the outline."""
    path = data.get("prestretch", {})
    rule = {key: path[key] for key in ("thickness",) if key in path}
    gravity = in_si("gravity", data.get("gravity", {}))
    return {
        "name": data.get("specimen", {}).get("name", "specimen"),
        "prestretch": Prestretch(_stretches(data), **rule),
        "gravity": gravity.get("acceleration", 0.0),
        "mesh": MeshSize(**in_si("mesh", data.get("mesh", {}))),
        "supports": supports_from(data.get("supports", {})),
        "loads": loads_from(data.get("loads", {})),
        "obstacles": obstacles_from(data.get("obstacles", {})),
    }


def _stretches(data: Tables) -> Any:
    """Return the prestretches of a file; a sheet under loads may have none."""
    path = data.get("prestretch", {})
    if "milestones" not in path and data.get("loads"):
        return [1.0]
    return required("prestretch", path, "milestones")


def milestones_in_file(specimen: Specimen) -> list[Any]:
    """Return the milestones as a file has them: a number if both directions are stretched."""
    return [x if x == y else [x, y] for x, y in specimen.prestretch.milestones]


def last_tables(specimen: Specimen) -> dict[str, Any]:
    """Return the tables of a file after those of the layers and the prestretch."""
    size = {key: getattr(specimen.mesh, key) for key in COMMON["mesh"]}
    held = {"supports": supports_to(specimen.supports), "loads": loads_to(specimen.loads)}
    held["obstacles"] = obstacles_to(specimen.obstacles)
    return {
        **{table: content for table, content in held.items() if content},
        "gravity": {"acceleration": specimen.gravity},
        "mesh": {key: value for key, value in size.items() if value is not None},
    }
