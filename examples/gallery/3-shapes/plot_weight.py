"""
How much its weight matters
===========================

``gravity`` is a true dead load along -z. The sheet is held at its centre. The paper's specimen is
soft and wide: a few percent of the earth's gravity can be seen.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import bilayer

specimen = replace(bilayer.paper_specimen().with_milestones([1.06]), mesh=bilayer.MeshSize(0.006))
mesh = bilayer.generate_mesh(specimen)
accelerations = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
heights = np.array(
    [
        bilayer.solve(replace(specimen, gravity=g), "dshell", mesh=mesh)["height"].item()
        for g in accelerations
    ]
)

# %%
# A live equilibrium gives the derivative of the whole shape by the load without a second solution,
# from its factorised tangent. It is held here against the difference of two solutions.

loads = (0.1, 0.11)
points = [
    next(
        p for p in bilayer.follow(replace(specimen, gravity=g), "dshell", mesh=mesh) if p.share == 1
    )
    for g in loads
]
linearised = points[0].linearised()
by_load = linearised.position_change(-linearised.solve(linearised.residual_by("gravity")))
difference = (points[1].position - points[0].position) / (loads[1] - loads[0])
error = np.linalg.norm(by_load - difference) / np.linalg.norm(difference)
print(f"derivative against difference: {100 * error:.2f} % apart")
assert error < 0.03

# %%
figure, axes = plt.subplots(figsize=(4.4, 3.2), layout="constrained")
axes.plot(accelerations, 1e3 * heights, "o-")
axes.set(xlabel="acceleration (m/s$^2$)", ylabel="height (mm)")
figure.savefig("weight.png")
