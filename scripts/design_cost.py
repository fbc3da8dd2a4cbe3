"""What the gradient of a design costs beside its shape: CPU time of the shell, for one design file.

The adjoint is the factor of the equilibrium's stiffness, one solution with it, and the derivative
by every variable. The curvature takes one more solution for each variable.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

from bilayer import generate_mesh, read_design
from bilayer.designing.distance import TargetDistance
from bilayer.designing.equilibria import Model, SheetMesh, find_shape
from bilayer.solvers.registry import solver_named

REPEATS = 3
STEP = 0.05
"""Of every variable, as a share of its range, to a design nearby."""


def seconds(action: Callable[[], Any]) -> tuple[float, Any]:
    """Return the least CPU time of an action, s, and what it returns."""
    times = []
    for _ in range(REPEATS):
        begun = time.process_time()
        result = action()
        times.append(time.process_time() - begun)
    return min(times), result


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("design", help="a design file")
    task = read_design(parser.parse_args().design)
    model = Model(solver_named("dshell"), task.settings)
    sheet = SheetMesh(task.specimen, generate_mesh(task.specimen))
    variables = task.variables
    from_flat, shape = seconds(lambda: find_shape(model, task.specimen, sheet))
    nearby = variables.specimen(task.specimen, variables.shares_of(task.specimen) + STEP)
    saved = shape.equilibrium.save()
    from_near, _ = seconds(lambda: find_shape(model, nearby, sheet, saved))
    target = TargetDistance(task.target.surface, task.target.is_size_free)
    place = target.measure_anew(shape.surface).place
    distance_time, distance = seconds(lambda: target.measure(shape.surface, place))
    factor, equations = seconds(shape.equilibrium.linearised)
    shape.linearised = equations
    rest, _ = seconds(lambda: shape.gradient(distance.gradient, variables.names))
    changes, _ = seconds(lambda: shape.changes(variables.names))
    print(f"{len(sheet.mesh.triangles)} triangles, {len(variables.names)} variables")
    for name, spent in (
        ("shape from flat", from_flat),
        ("shape from one nearby", from_near),
        ("distance and its best place", distance_time),
        ("adjoint: factor", factor),
        ("adjoint: solution and derivatives", rest),
        ("curvature: a solution for each variable", changes),
    ):
        print(f"{name:42}{spent:8.3f} s")
    adjoint = factor + rest
    print(f"adjoint over a shape from flat:   {adjoint / from_flat:.1%}")
    print(f"adjoint over a shape from nearby: {adjoint / from_near:.1%}")


if __name__ == "__main__":
    main()
