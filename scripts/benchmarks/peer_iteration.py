"""One Newton iteration of dismech-python on a mesh, timed; run by the peer's own interpreter.

    python peer_iteration.py CHECKOUT MESH.npz REPEATS

The mesh file has `flat` and `bent`, node positions (n, 3), and `triangles` (m, 3). Prints one JSON
object of CPU seconds.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np


def main(checkout: str, mesh_file: str, repeats: str) -> None:
    sys.path.insert(0, str(Path(checkout, "src")))
    import dismech

    mesh = np.load(mesh_file)
    begin = time.process_time()
    geometry = dismech.Geometry(mesh["flat"], np.empty((0, 2), dtype=int), mesh["triangles"])
    robot = dismech.SoftRobot(
        dismech.GeomParams(rod_r0=0.0, shell_h=2e-3),
        dismech.Material(1000.0, 0.0, 1e5, 0.0, 0.5),
        geometry,
        dismech.SimParams(
            static_sim=True, two_d_sim=False, use_mid_edge=False, use_line_search=False,
            log_data=False, log_step=1, show_floor=False, dt=1e-2, max_iter=1, total_time=1e-2,
            plot_step=1, tol=1e-9, ftol=1e-9, dtol=1e-9, solver="pardiso", sparse=True,
        ),
        dismech.Environment(),
    )  # fmt: skip
    robot = robot.fix_nodes(mesh["triangles"][0])
    stepper = dismech.ImplicitEulerTimeStepper(robot)
    set_up = time.process_time() - begin

    q = robot.state.q.copy()
    q[: mesh["bent"].size] = mesh["bent"].reshape(-1)
    free = robot.state.free_dof
    stepper._n_dof = len(q)  # as `TimeStepper.step` prepares its iterations
    stepper._forces = np.empty(len(q))

    def assemble():
        stepper._compute_forces_and_jacobian(robot, q, np.zeros_like(q))
        return stepper._jacobian[free, :][:, free], stepper._forces[free]

    assembly, solution = [], []
    for _ in range(int(repeats)):
        q[0] += 1e-12  # another matrix each time, so that the solver keeps no factor
        begin = time.process_time()
        jacobian, force = assemble()
        middle = time.process_time()
        stepper._solver.solve(jacobian, force)
        assembly.append(middle - begin)
        solution.append(time.process_time() - middle)
    print(json.dumps({"set_up": set_up, "assembly": min(assembly), "solution": min(solution)}))


if __name__ == "__main__":
    main(*sys.argv[1:])
