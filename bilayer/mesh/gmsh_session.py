"""gmsh for the time of one drawing, within whatever else the process does with it."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from bilayer.errors import ComputationError
from bilayer.runtime.surroundings import variables_changed

OPTIONS: Mapping[str, float] = {
    "General.Terminal": 0,
    "General.NumThreads": 1,  # the same mesh at every run
    "Mesh.Algorithm": 6,  # frontal Delaunay: near-equilateral triangles
    "Mesh.ElementOrder": 1,
    "Mesh.MeshSizeFactor": 1,
    "Mesh.MeshSizeExtendFromBoundary": 1,
    "Mesh.MeshSizeFromPoints": 1,
    "Mesh.RecombineAll": 0,
}
"""Options on which a mesh depends; the user's own values are restored."""

_MODEL = "bilayer-shells"


@contextmanager
def gmsh_session(options: Mapping[str, float] | None = None) -> Iterator[Any]:
    """Give gmsh, quiet and with an empty model; leave its options and models as they were.

    Parameters
    ----------
    options : mapping of str to float, optional
        Further options for the time of the session.

    Raises
    ------
    ComputationError
        gmsh is not there.
    """
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise ComputationError(
            f"gmsh cannot be loaded ({error}): install the package gmsh with the system libraries "
            "that it names (on Debian: apt install python3-gmsh), or give a mesh file"
        ) from error
    chosen = {**OPTIONS, **(options or {})}
    if gmsh.isInitialized():
        with _users_session_kept(gmsh, chosen):
            yield gmsh
        return
    with variables_changed({"HOME": os.devnull}):  # gmsh's windows begin to keep settings there
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        _set(gmsh, chosen)
        gmsh.model.add(_MODEL)
        yield gmsh
    finally:
        gmsh.finalize()


@contextmanager
def _users_session_kept(gmsh: Any, options: Mapping[str, float]) -> Iterator[None]:
    before = {name: gmsh.option.getNumber(name) for name in options}
    current = gmsh.model.getCurrent()
    try:
        _set(gmsh, options)
        gmsh.model.add(_MODEL)
        yield
    finally:
        gmsh.model.setCurrent(_MODEL)
        gmsh.model.remove()
        if current in gmsh.model.list():
            gmsh.model.setCurrent(current)
        _set(gmsh, before)


def _set(gmsh: Any, options: Mapping[str, float]) -> None:
    for name, value in options.items():
        gmsh.option.setNumber(name, value)
