"""Result files that are whole NetCDF and no result: other types, shapes, contents, attributes."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

from attack.attempt import Attempt, Right
from attack.result_bytes import VERBS, reading

INTEGER = ("face_nodes", "region", "converged", "iterations", "load_steps", "unstable_modes")
REQUIRED_ATTRIBUTES = (
    "specimen",
    "settings",
    "solver",
    "model",
    "versions",
    "git_commit",
    "stop_reason",
)
UNKNOWN_TABLE = "[specimen]\nouter_radius = -1\n"
TEXTS = (
    "",
    "x",
    "[",
    "a = ",
    UNKNOWN_TABLE,
    "\0",
    "\x1b[31m",
    "x" * 100_000,
    "[" * 5000,
    "format = 1979-05-27",
)

Variable = dict[str, Any]
"""Of a file: `dims`, `values` (an array), `attrs`, and `options` of netCDF4."""


class Content:
    """A NetCDF file in memory: dimensions, variables, attributes; to be changed and written.

    Parameters
    ----------
    path : Path
        The file that it begins with.
    """

    def __init__(self, path: Path) -> None:
        with netCDF4.Dataset(path) as stored:
            stored.set_auto_maskandscale(False)
            self.attrs = {name: stored.getncattr(name) for name in stored.ncattrs()}
            self.sizes = {name: len(dim) for name, dim in stored.dimensions.items()}
            self.variables: dict[str, Variable] = {
                name: {
                    "dims": variable.dimensions,
                    "values": np.asarray(variable[...]),
                    "attrs": {key: variable.getncattr(key) for key in variable.ncattrs()},
                    "options": {},
                }
                for name, variable in stored.variables.items()
            }
        self.unlimited: tuple[str, ...] = ()
        self.groups: tuple[str, ...] = ()

    def write(self, path: Path) -> None:
        """Write the file."""
        with netCDF4.Dataset(path, "w") as made:
            for name, size in self.sizes.items():
                made.createDimension(name, None if name in self.unlimited else size)
            for name in self.groups:
                made.createGroup(name)
            for key, value in self.attrs.items():
                made.setncattr(key, value)
            for name, parts in self.variables.items():
                values = np.asarray(parts["values"])
                is_text = values.dtype.kind in "OUS"
                attrs = dict(parts["attrs"])
                fill = attrs.pop("_FillValue", None)
                if is_text or (
                    fill is not None and np.asarray(fill).dtype.kind != values.dtype.kind
                ):
                    fill = None
                dims = list(parts["dims"])
                for axis, size in enumerate(values.shape):
                    if axis >= len(dims) or self.sizes.get(dims[axis]) != size:
                        own = f"{name}_{axis}"
                        made.createDimension(own, size)
                        dims[axis : axis + 1] = [own]
                dims = dims[: values.ndim]
                kind: Any = str if is_text else values.dtype
                stored = made.createVariable(name, kind, dims, fill_value=fill, **parts["options"])
                stored.set_auto_maskandscale(False)
                stored.setncatts(attrs)
                stored[...] = values.astype(object) if is_text else values


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    required = _required_variables()
    for name, change in {**_changes(required, bench), **_by_hand()}.items():
        right = _right_of(name)
        yield _attempt(bench, name, change, "info", right)
        verb = chance.choice([verb for verb in VERBS if verb not in ("info", "resume")])
        weaker = Right.HANDLED if right is not Right.REFUSED else right
        yield _attempt(bench, name, change, verb, weaker)
    for name, change in _good().items():
        for verb in ("info", "convert", "mesh", "compare"):
            yield _attempt(bench, f"good: {name}", change, verb, Right.ACCEPTED)
    for name, change in _resume_points().items():

        def make(path: Path, change: Any = change) -> None:
            path.write_bytes(bench.unfinished.read_bytes())
            with netCDF4.Dataset(path, "a") as stored:
                change(stored)

        yield reading(
            bench, "result structure", f"resume point: {name}", "resume", make, Right.EITHER
        )


def _required_variables() -> tuple[str, ...]:
    from bilayer.results.schema import REQUIRED

    return REQUIRED["variable"]


def _attempt(
    bench: Any, name: str, change: Callable[[Content], None], verb: str, right: Right
) -> Attempt:
    def make(path: Path) -> None:
        content = Content(bench.result)
        change(content)
        content.write(path)

    says = r"r\.nc|start" if right is Right.REFUSED else ""
    return reading(bench, "result structure", name, verb, make, right, says)


def _right_of(name: str) -> Right:
    """Return what is right for a change by its name: a "?" at its end leaves it open."""
    return Right.EITHER if name.endswith("?") else Right.REFUSED


def _changes(required: tuple[str, ...], bench: Any) -> dict[str, Callable[[Content], None]]:
    made: dict[str, Callable[[Content], None]] = {}
    names = list(Content(bench.result).variables)
    for name in names:
        open_ = "" if name in required else "?"

        def values(change: Callable[[Any], Any], name: str = name) -> Callable[[Content], None]:
            def apply(content: Content) -> None:
                part = content.variables[name]
                part["values"] = change(part["values"])

            return apply

        made[f"{name} is missing{open_}"] = lambda content, name=name: content.variables.pop(name)
        made[f"{name} is text{open_}"] = values(lambda a: np.full(a.shape, "x", dtype=object))
        made[f"{name} is one number{open_}"] = values(lambda a: np.float64(5.0))
        made[f"{name} is longer{open_}"] = values(
            lambda a: np.concatenate([a, a]) if np.ndim(a) else np.array([a, a])
        )
        made[f"{name} has one more axis{open_}"] = values(lambda a: np.asarray(a)[..., None])
        made[f"{name} is complex-like pairs{open_}"] = values(lambda a: np.zeros((3, 7)))
        made[f"{name} is empty{open_}"] = values(lambda a: np.zeros((0,) * max(1, np.ndim(a))))
        made[f"{name} is bytes{'' if name == 'face_nodes' else '?'}"] = values(
            lambda a: np.zeros(np.shape(a), dtype="i1")
        )
        made[f"{name} is nan{'?'}"] = values(lambda a: np.full(np.shape(a), np.nan))
        made[f"{name} is inf{'?'}"] = values(lambda a: np.full(np.shape(a), np.inf))
        made[f"{name} is huge{'?'}"] = values(lambda a: np.full(np.shape(a), 1e300))
        if name in INTEGER:
            made[f"{name} is -7{'' if name in ('face_nodes', 'region') else '?'}"] = values(
                lambda a: np.full(a.shape, -7, dtype=a.dtype)
            )
            made[f"{name} is 2^30{'' if name in ('face_nodes', 'region') else '?'}"] = values(
                lambda a: np.full(a.shape, 2**30, dtype="i4")
            )
            made[f"{name} is half{open_ or ('' if name in ('face_nodes', 'region') else '?')}"] = (
                values(lambda a: np.full(a.shape, 0.5))
            )
    for bad in ("nan", "inf", "huge"):  # a mesh with such a node is none
        made[f"reference_position is {bad}"] = made.pop(f"reference_position is {bad}?")
    for attribute in REQUIRED_ATTRIBUTES:
        open_ = "" if attribute in ("specimen", "settings") else "?"
        made[f"attribute {attribute} is missing"] = lambda content, a=attribute: content.attrs.pop(
            a
        )
        for number, value in enumerate((5, 5.5, np.array([1, 2, 3]), np.array([])), start=1):
            made[f"attribute {attribute} is number {number}{open_}"] = _setting(attribute, value)
        for number, text in enumerate(TEXTS, start=1):
            no_setting = attribute == "settings" and text in ("", "\0", UNKNOWN_TABLE)
            made[f"attribute {attribute} is text {number}{'?' if no_setting else open_}"] = (
                _setting(attribute, text)
            )
    return made


def _setting(attribute: str, value: Any) -> Callable[[Content], None]:
    return lambda content: content.attrs.__setitem__(attribute, value)


def _by_hand() -> dict[str, Callable[[Content], None]]:
    def variable(name: str, change: Callable[[Any], Any]) -> Callable[[Content], None]:
        def apply(content: Content) -> None:
            content.variables[name]["values"] = change(content.variables[name]["values"].copy())

        return apply

    def put(index: Any, value: Any) -> Callable[[Any], Any]:
        def change(array: Any) -> Any:
            array[index] = value
            return array

        return change

    def rename(content: Content) -> None:
        content.sizes = {f"x{name}": size for name, size in content.sizes.items()}
        for part in content.variables.values():
            part["dims"] = tuple(f"x{name}" for name in part["dims"])

    return {
        "all dimensions renamed": rename,
        "no variables": lambda content: content.variables.clear(),
        "no attributes": lambda content: content.attrs.clear(),
        "another format": _setting("format", "something else"),
        "the format is a number": _setting("format", 5),
        "the format is a list": _setting("format", np.array([1, 2])),
        "the schema is newer": _setting("schema_version", 99),
        "the schema is a text": _setting("schema_version", "1"),
        "the schema is half": _setting("schema_version", 1.5),
        "the schema is a list": _setting("schema_version", np.array([1, 1])),
        "the schema is minus 1?": _setting("schema_version", -1),
        "an unknown solver?": _setting("solver", "elsewhere"),
        "an unknown model?": _setting("model", "elsewhere"),
        "a solver with a path?": _setting("solver", "../../x"),
        "an unknown setting?": _setting("settings", "frobnicate = 1\n"),
        "one node counted twice in a face?": variable("face_nodes", put((0, 1), 0)),
        "one face beyond the nodes": variable("face_nodes", put((0, 0), 10**6)),
        "one face below 0": variable("face_nodes", put((0, 0), -1)),
        "all faces the same": variable("face_nodes", lambda a: np.broadcast_to(a[:1], a.shape)),
        "a face clockwise": variable("face_nodes", lambda a: a[:, ::-1]),
        "face nodes from 1?": variable("face_nodes", lambda a: a + 1),
        "face nodes in 64 bits from elsewhere": variable(
            "face_nodes", lambda a: a.astype(np.int64) + 2**31
        ),
        "fewer faces than regions": variable("face_nodes", lambda a: a[:-1]),
        "faces of four nodes": variable("face_nodes", lambda a: np.column_stack([a, a[:, 0]])),
        "nodes in the plane alone?": variable("reference_position", lambda a: a[:, :2]),
        "one node at nan": variable("reference_position", put((0, 0), np.nan)),
        "all nodes at one place": variable("reference_position", lambda a: np.zeros_like(a)),
        "more positions than nodes": variable("position", lambda a: np.concatenate([a, a], 1)),
        "fewer milestones in position": variable("position", lambda a: a[:1]),
        "a sheet of another size?": variable("reference_position", lambda a: 2 * a),
        "a region of another layer": variable("region", put(0, 7)),
        "converged is 2?": variable("converged", lambda a: a + 1),
        "converged, with a shape of nan?": variable("position", put((0, 0, 0), np.nan)),
        "a prestretch of -1?": variable("prestretch", put(0, -1.0)),
        "a prestretch of nan?": variable("prestretch_x", put(0, np.nan)),
        "prestretch above its parts?": variable("prestretch", put(0, 3.0)),
        "specimen of other layers": _setting(
            "specimen", "[specimen]\nname='x'\nouter_radius=0.04\n"
        ),
    }


def _good() -> dict[str, Callable[[Content], None]]:
    def with_options(**options: Any) -> Callable[[Content], None]:
        def apply(content: Content) -> None:
            for part in content.variables.values():
                if np.asarray(part["values"]).dtype.kind not in "OUS" and np.ndim(part["values"]):
                    part["options"] = options

        return apply

    def more(content: Content) -> None:
        content.sizes["of_mine"] = 4
        content.variables["mine"] = {
            "dims": ("of_mine",),
            "values": np.arange(4.0),
            "attrs": {"units": "m"},
            "options": {},
        }
        content.attrs["history"] = "ncks -O a.nc b.nc\n"

    def older(content: Content) -> None:
        for name in ("self_contact_gap", "last_position", "last_prestretch", "layers_present"):
            content.variables.pop(name, None)
        content.attrs.pop("reference_surface", None)
        content.attrs.pop("start", None)

    def turned(content: Content) -> None:
        content.variables = dict(reversed(content.variables.items()))
        content.attrs = dict(reversed(content.attrs.items()))

    def wider(content: Content) -> None:
        for part in content.variables.values():
            values = np.asarray(part["values"])
            if values.dtype.kind == "i":
                part["values"] = values.astype("i8")
                part["attrs"].pop("_FillValue", None)

    return {
        "as it is": lambda content: None,
        "compressed": with_options(zlib=True, shuffle=True),
        "with checksums": with_options(fletcher32=True),
        "of the other byte order": with_options(endian="big"),
        "with variables and attributes of one's own": more,
        "in another order": turned,
        "integers of 64 bits": wider,
        "with a group of one's own": lambda content: setattr(content, "groups", ("mine",)),
        "with an unlimited dimension": lambda content: setattr(
            content, "unlimited", ("prestretch",)
        ),
        "older, without what came later": older,
    }


def _resume_points() -> dict[str, Callable[[Any], None]]:
    def attribute(name: str, value: Any) -> Callable[[Any], None]:
        return lambda stored: stored["resume"].setncattr(name, value)

    def fill(value: float) -> Callable[[Any], None]:
        def apply(stored: Any) -> None:
            for variable in stored["resume"].variables.values():
                if variable.dtype is not str and variable.dtype.kind == "f":
                    variable[...] = value

        return apply

    def rename(stored: Any) -> None:
        for name in list(stored["resume"].variables):
            stored["resume"].renameVariable(name, f"{name}_x")

    return {
        "tried is a text": attribute("tried", "x"),
        "tried is negative": attribute("tried", -5),
        "tried is beyond": attribute("tried", 99),
        "tried is half": attribute("tried", 0.5),
        "tried is a list": attribute("tried", np.array([1, 2])),
        "tried is gone": lambda stored: stored["resume"].delncattr("tried"),
        "reasons is gone": lambda stored: stored["resume"].delncattr("reasons"),
        "reasons is a number": attribute("reasons", 5),
        "all variables renamed": rename,
        "numbers are nan": fill(np.nan),
        "numbers are 1e300": fill(1e300),
        "numbers are 0": fill(0.0),
    }
