"""The command line with a signal at a placed moment: `python3 -m attack.placed PLACE WORDS...`.

PLACE is a JSON object: `function` ("module:Name.function") and `call` (which call of it, from 1),
or `module` (while it is loaded); `number` of the signal; `to`: "self", "group", "parent"; `log`, a
file that notes each milestone that is reached; `ranks`: the only one that is signalled, or null.
"""

from __future__ import annotations

import functools
import importlib
import importlib.abc
import json
import os
import signal
import sys
import time
from pathlib import Path
from typing import Any

KEEPER = ("bilayer.solvers.recording", "Recorder.__call__")
RANK = "OMPI_COMM_WORLD_RANK"


def main() -> None:
    place = json.loads(sys.argv[1])
    if int(os.environ.get(RANK, "0")) == 0:
        log = Path(place["log"])
        sys.meta_path.insert(0, _Wrapping(*KEEPER, functools.partial(_noting, log)))
        if "module" in place:
            sys.meta_path.insert(0, _Loading(place["module"], functools.partial(_strike, place)))
        else:
            module, _, name = place["function"].partition(":")
            wrap = functools.partial(_striking, place)
            if module in sys.modules:
                _wrap_in(sys.modules[module], name, wrap)
            else:
                sys.meta_path.insert(0, _Wrapping(module, name, wrap))
    sys.argv = ["bilayer", *sys.argv[2:]]
    from bilayer.__main__ import main as command

    sys.exit(command())


def _strike(place: dict[str, Any]) -> None:
    log = Path(place["log"])
    with log.open("a", encoding="utf-8") as lines:
        lines.write("struck\n")
    number = place["number"]
    if number == signal.SIGKILL:
        os.killpg(os.getpgid(0), number)
    target = {"self": os.getpid(), "parent": os.getppid()}.get(place["to"])
    if target is None:
        os.killpg(os.getpgid(0), number)
    else:
        os.kill(target, number)
    if place["to"] == "parent":
        time.sleep(0.2)  # it comes by way of the other process


def _striking(place: dict[str, Any], function: Any) -> Any:
    calls = []

    @functools.wraps(function)
    def call(*args: Any, **options: Any) -> Any:
        calls.append(None)
        if len(calls) == place["call"]:
            _strike(place)
        return function(*args, **options)

    return call


def _noting(log: Path, keep: Any) -> Any:
    @functools.wraps(keep)
    def call(recorder: Any, step: Any) -> None:
        keep(recorder, step)
        if step.is_at_target and recorder._output is not None:  # not one of the start's
            with log.open("a", encoding="utf-8") as lines:
                lines.write(f"milestone {step.index}\n")

    return call


def _wrap_in(module: Any, name: str, wrap: Any) -> None:
    *owners, last = name.split(".")
    owner = functools.reduce(getattr, owners, module)
    setattr(owner, last, wrap(getattr(owner, last)))


class _Loading(importlib.abc.MetaPathFinder):
    """Does something when a module is about to be loaded."""

    def __init__(self, module: str, action: Any) -> None:
        self._module, self._action = module, action

    def find_spec(self, name: str, path: Any, target: Any = None) -> None:
        if name == self._module:
            sys.meta_path.remove(self)
            self._action()


class _Wrapping(importlib.abc.MetaPathFinder):
    """Wraps a function of a module once that is loaded."""

    def __init__(self, module: str, name: str, wrap: Any) -> None:
        self._module, self._name, self._wrap = module, name, wrap

    def find_spec(self, name: str, path: Any, target: Any = None) -> Any:
        if name != self._module:
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        if spec is None or spec.loader is None:
            return spec
        run = spec.loader.exec_module

        def exec_module(module: Any) -> None:
            run(module)
            _wrap_in(module, self._name, self._wrap)

        spec.loader.exec_module = exec_module  # type: ignore[method-assign]
        return spec


if __name__ == "__main__":
    main()
