"""Tables of a testing machine, as other programs write them, and damaged."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

from attack.attempt import Attempt, Right
from attack.values import NO_FILES

FIT = ("fit", "t.csv", "--law", "neo-hookean")
DAMAGES = 40


def table(head: str = "stretch,stress_kPa", separator: str = ",", decimal: str = ".") -> str:
    """Return an ideal test of a neo-Hookean block, mu = 100 kPa."""
    rows = [head.replace(",", separator)]
    for k in range(1, 21):
        stretch = 1 + 0.02 * k
        numbers = (f"{stretch:.4f}", f"{100 * (stretch - stretch**-2):.5f}")
        rows.append(separator.join(number.replace(".", decimal) for number in numbers))
    return "\n".join(rows) + "\n"


def attempts(bench: Any, chance: random.Random) -> Iterator[Attempt]:
    good = table()
    for name, content in {
        "as it is": good,
        "CRLF": good.replace("\n", "\r\n"),
        "a byte order mark": good.encode("utf-8-sig"),
        "tabs": table(separator="\t"),
        "semicolons": table(separator=";"),
        "comments": "# made by hand\n" + good,
        "per cent": table("strain_%,stress_kPa"),
    }.items():
        yield _of(f"good: {name}", content, Right.ACCEPTED)
    comma = table(separator=";", decimal=",")
    yield _of("good: decimal commas between semicolons", comma, Right.EITHER)
    for name, content in {
        "empty": "",
        "a line of names alone": "stretch,stress\n",
        "one row": "\n".join(good.splitlines()[:2]),
        "without names": "\n".join(good.splitlines()[1:]),
        "one column": "stretch\n1.1\n1.2\n",
        "other names": table("a,b"),
        "an unknown unit": table("stretch,stress (kgf)"),
        "a unit of another kind": table("stretch,stress (mm)"),
        "two columns of one name": table("stress,stress"),
        "nan in it": good.replace("1.1000", "nan"),
        "inf in it": good.replace("1.1000", "inf"),
        "a text in it": good.replace("1.1000", "x"),
        "a stretch of 0": good.replace("1.1000", "0.0000"),
        "a stretch below 0": good.replace("1.1000", "-1.1000"),
        "a row too short": good + "1.5\n",
        "a row too long": good + "1.5,2,3\n",
        "an overflow": good.replace("1.1000", "1e999"),
        "all stretches 1": "stretch,stress\n" + "1.0,0.0\n" * 20,
        "all the same": "stretch,stress\n" + "1.1,5.0\n" * 20,
        "binary": bytes(range(256)) * 4,
        "zeros": bytes(400),
        "UTF-16": good.encode("utf-16"),
        "an open quote": 'stretch,"stress\n1.1,2\n',
        "a NUL": good + "\0",
        **NO_FILES,
    }.items():
        right = Right.REFUSED
        if name in ("all the same", "one row", "a stretch of 0", "a row too long", "a NUL"):
            right = Right.EITHER
        yield _of(name, content, right)
    yield _of("stresses of 0", "stretch,stress\n1.1,0\n1.2,0\n1.3,0\n", Right.HANDLED)
    yield _of("stresses that fall", table().replace(",", ",-"), Right.HANDLED)
    yield _of("numbers of 1e300", table().replace("\n1.", "\n1e300"), Right.HANDLED)
    for number in range(DAMAGES):
        end = chance.randrange(len(good) - 1)
        yield _of(f"cut off {number}", good[:end], Right.HANDLED)
        damaged = list(good)
        for _ in range(chance.choice((1, 2, 6))):
            damaged[chance.randrange(len(damaged))] = chance.choice('0123456789.,;-+eE \n\t"x\0')
        yield _of(f"changed {number}", "".join(damaged), Right.HANDLED)
    for option, values in {
        "--law": ("", "x", "NEO-HOOKEAN", "\x1b[31m"),
        "--up-to": ("", "x", "nan", "inf", "-1", "0", "1", "9" * 400),
        "--poisson-ratio": ("", "x", "nan", "0.6", "-2", "1e400"),
        "--stretch-column": ("", "x", "\x1b[31m"),
        "--stress-column": ("", "x", "\x1b[31m"),
        "--name": ("", "a b", "\x1b[31m", "a\nb", "1st"),
    }.items():
        for value in values:
            right = Right.EITHER if (option, value) == ("--up-to", "inf") else Right.REFUSED
            yield _of(f"{option} {value[:9]!r}", good, right, more=(f"{option}={value}",))


def _of(
    name: str, content: Any, right: Right = Right.REFUSED, more: tuple[str, ...] = ()
) -> Attempt:
    says = "t.csv|--|column" if right is Right.REFUSED and not more else ""
    return Attempt("material test", name, (*FIT, *more), {"t.csv": content}, right, says=says)
