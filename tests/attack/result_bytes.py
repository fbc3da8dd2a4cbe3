"""Result files of which some bytes are not what they were: flipped, cut off, doubled, zeroed."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from typing import Any

from attack.attempt import Attempt, Right

FLIPS, DAMAGES = 300, 120
VERBS: dict[str, tuple[str, ...]] = {
    "info": ("info", "r.nc"),
    "convert": ("convert", "r.nc", "-o", "a.vtu"),
    "compare": ("compare", "good.nc", "r.nc"),
    "mesh": ("solve", "s.toml", "--solver", "dshell", "--mesh", "r.nc", "-o", "a.nc", "--quiet"),
    "start": (
        "solve",
        "s.toml",
        "--solver",
        "dshell",
        "--mesh",
        "good.nc",
        "--start",
        "r.nc",
        "-o",
        "a.nc",
        "--quiet",
    ),
    "resume": (
        "solve",
        "s.toml",
        "--solver",
        "dshell",
        "--prestretch",
        "1.001",
        "1.002",
        "-o",
        "r.nc",
        "--resume",
        "--quiet",
    ),
    "plot": ("plot", "r.nc", "-o", "a.png"),
    "view": ("view", "r.nc", "-o", "a.html", "--no-open"),
    "rerun": ("rerun", "r.nc", "--quiet"),
}
"""The verbs that read a result."""
OUTPUTS = {
    "convert": ("a.vtu",),
    "mesh": ("a.nc",),
    "start": ("a.nc",),
    "resume": ("r.nc",),
    "plot": ("a.png",),
    "view": ("a.html",),
}
OFTEN = (
    "info",
    "info",
    "info",
    "convert",
    "compare",
    "mesh",
    "start",
    "resume",
    "plot",
    "rerun",
    "view",
)


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    finished, unfinished = bench.result.read_bytes(), bench.unfinished.read_bytes()
    for number in range(FLIPS):
        verb = chance.choice(OFTEN)
        base = unfinished if verb == "resume" or number % 7 == 0 else finished
        damaged = flipped(base, chance)
        yield reading(bench, "result bytes", f"flipped {number}", verb, damaged, Right.HANDLED)
    for number in range(DAMAGES):
        verb = chance.choice(OFTEN)
        name, damage = chance.choice(tuple(DAMAGE.items()))
        base = unfinished if verb == "resume" else finished
        right = Right.REFUSED if name == "cut off" and verb != "resume" else Right.HANDLED
        damaged = damage(base, chance)
        yield reading(bench, "result bytes", f"{name} {number}", verb, damaged, right)
    for verb in VERBS:
        for name, content in {
            "empty": b"",
            "one byte": b"\x89",
            "the signature alone": finished[:8],
            "zeros": bytes(len(finished)),
            "a text": b"hello\n" * 100,
            "netCDF-3": b"CDF\x01" + bytes(100),
            "HDF4": b"\x0e\x03\x13\x01" + bytes(100),
            "a zip": b"PK\x03\x04" + bytes(100),
        }.items():
            yield reading(bench, "result bytes", name, verb, content, Right.REFUSED, says="r.nc")


def reading(
    bench: Any, kind: str, name: str, verb: str, content: Any, right: Right, says: str = ""
) -> Attempt:
    """Return the attempt to read a result file by a verb."""
    files = {"s.toml": bench.specimen, "good.nc": bench.result, "r.nc": content}
    return Attempt(
        kind, f"{verb}: {name}", VERBS[verb], files, right, OUTPUTS.get(verb, ()), says=says
    )


def flipped(content: bytes, chance: random.Random) -> bytes:
    """Return the bytes with one to eight bits flipped, more often where the structure is."""
    damaged = bytearray(content)
    for _ in range(chance.choice((1, 1, 1, 2, 8))):
        last = chance.choice((len(damaged), len(damaged), 4096, 512))
        damaged[chance.randrange(min(last, len(damaged)))] ^= 1 << chance.randrange(8)
    return bytes(damaged)


def _cut_off(content: bytes, chance: random.Random) -> bytes:
    return content[: chance.randrange(8, len(content) - 1)]


def _zeroed(content: bytes, chance: random.Random) -> bytes:
    at, length = chance.randrange(len(content)), chance.choice((1, 16, 512, 4096))
    return content[:at] + bytes(min(length, len(content) - at)) + content[at + length :]


def _shifted(content: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(content))
    return content[:at] + bytes(chance.choice((1, 2, 8))) + content[at:]


def _crlf(content: bytes, chance: random.Random) -> bytes:
    return content.replace(b"\n", b"\r\n")


def _doubled(content: bytes, chance: random.Random) -> bytes:
    return content + content


def _noise(content: bytes, chance: random.Random) -> bytes:
    at, length = chance.randrange(len(content)), chance.choice((4, 64, 1024))
    return content[:at] + chance.randbytes(length) + content[at + length :]


DAMAGE: dict[str, Callable[[bytes, random.Random], bytes]] = {
    "cut off": _cut_off,
    "zeroed": _zeroed,
    "shifted": _shifted,
    "line ends of Windows": _crlf,
    "doubled": _doubled,
    "noise": _noise,
}
