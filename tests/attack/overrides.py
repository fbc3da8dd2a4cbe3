"""`--set`: every field of the short form with what it does not take, and no field at all."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from typing import Any

from attack.attempt import Attempt, Right
from attack.specimen_files import SOLVE
from attack.toml_text import fragment
from attack.values import BAD, HUGE

FIELDS = {
    "specimen.outer_radius": "length",
    "cut.strips": "count",
    "cut.cutout_angle": "angle",
    "substrate.thickness": "length",
    "kirigami.young_modulus": "stress",
    "kirigami.law": "choice",
    "prestretch.milestones": "stretches",
    "mesh.size": "length",
}
SETTINGS: dict[str, tuple[Any, ...]] = {
    "tolerance": (0, 1, -1, 2, "x", True, [], 1e300, HUGE, ""),
    "max_iterations": (0, -1, 2.5, "x", True, [], 1e30, HUGE, ""),
    "ramp": (0, -1, "x", True, [], 1e-30, HUGE, "", 5e-324, 1e-12),
    "longest_step": (0, -1, "x", True, [], 1e-30, HUGE, "", 5e-324),
    "smallest_step": (0, -1, "x", True, [], HUGE, "", 2.0),
    "coarse_triangles": (-1, 2.5, "x", [], HUGE, ""),
    "total_time": (0, -1, "x", [], 1e300, HUGE, ""),
    "time_step": (0, -1, "x", [], 1e300, 1e-300, HUGE, ""),
    "damping_rate": (-1, "x", [], HUGE, ""),
    "method": ("x", 5, [], "", "STATIC", True),
    "branch": ("x", 5, [], "", "Lowest", True),
    "profile": ("x", 5, [], "", "cubic", True),
    "walls": ("x", 5, [], "", "free", True),
}
NO_OVERRIDE = (
    "",
    "=",
    "==",
    ".",
    "..",
    ".=",
    "a",
    "a=",
    "=5",
    "mesh",
    "mesh=",
    "mesh=5",
    "mesh.=5",
    ".size=5",
    "mesh.size",
    "mesh.size.=5",
    "mesh..size=5",
    "mesh.size.x=5",
    "mesh.siz=5",
    "Mesh.size=5",
    "meshsize=5",
    "mesh size=5",
    "mesh.size:5",
    "solver=5",
    "solver.=5",
    "solver.x=5",
    "solver..=5",
    "solver.model=hinge",
    "layers=5",
    "layers.substrate.thickness=1",
    "patterns.x.strips=5",
    "materials.x.law=linear",
    "cut=5",
    "cut=[]",
    "specimen={}",
    "\x1b[31m=5",
    "mesh.size=\x1b[31m",
    "mesh.\nsize=5",
    "mesh.size=1\n[gravity]\nacceleration=1",
    "mesh.size=0.02 # x\nlaw=1",
    "mesh.size=[" + "[" * 3000,
    "mesh.size=" + "{a=" * 3000,
    "a." * 3000 + "b=5",
    "a" * 50_000,
    "--mesh.size=5",
    "é.ü=5",
    "mesh.size=0,02",
    "mesh.size=0.02 0.02",
    "mesh.size=+-1",
    "mesh.size=٠.٠٢ kg",
    "%s.%d=1",
    "{0}.{1}=2",
    "mesh.size='",
    'mesh.size="""',
    "mesh.size=\\",
    "mesh.size=None",
    "mesh.size=null",
    "solver.petsc_options=x",
    "prestretch.layers=substrat",
    "__class__.__init__=1",
    "specimen.__class__=1",
    "solver.__class__=1",
    "solver.steps=1",
    "solver.stopping_is_a_result=true",
)


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    for field, kind in FIELDS.items():
        for label, value in BAD[kind].items():
            text = fragment(value)
            if "\0" in text:
                continue  # no word of a command line can hold it
            key = re.escape(field.rpartition(".")[2])
            yield _attempt(bench, f"{field}: {label}", f"{field}={text}", says=key)
    for name, values in SETTINGS.items():
        for value in values:
            text = fragment(value) if not isinstance(value, str) else value
            says = name if not (isinstance(value, str) and "\0" in value) else ""
            right = Right.REFUSED
            if name in ("ramp", "longest_step") and value in (1e-30, 5e-324, 1e-12):
                right = Right.HANDLED
            if name in ("tolerance",) and value == 1e300:
                right = Right.REFUSED
            yield _attempt(
                bench, f"solver.{name} = {str(value)[:12]}", f"solver.{name}={text}", right, says
            )
    for number, word in enumerate(NO_OVERRIDE):
        yield _attempt(bench, f"no override {number}: {word[:24]!r}", word)
    for word in (
        "mesh.size='20 mm'",
        "mesh.size = 0.02",
        " mesh.size=2e-2",
        "cut.strips=5.0",
        "specimen.name=a=b",
        "specimen.name='$x$'",
        "kirigami.law=neo-hookean",
        "mesh.size=0.02 m",
        "prestretch.milestones=[1.001]",
        "solver.tolerance=1e-7",
    ):
        right = Right.EITHER if word == "kirigami.law=neo-hookean" else Right.ACCEPTED
        yield _attempt(bench, f"good: {word}", word, right)
    yield _attempt(
        bench,
        "one twice, the last counts",
        "mesh.size=-1",
        Right.ACCEPTED,
        more=("--set", "mesh.size=0.02"),
    )


def _attempt(
    bench: Any,
    name: str,
    word: str,
    right: Right = Right.REFUSED,
    says: str = "",
    more: tuple[str, ...] = (),
) -> Attempt:
    words = (*SOLVE, f"--set={word}", *more)
    return Attempt("override", name, words, {"s.toml": bench.specimen}, right, ("a.nc",), says=says)
