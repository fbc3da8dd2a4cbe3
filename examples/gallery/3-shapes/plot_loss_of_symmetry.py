"""
An uncut disc loses its symmetry
================================

A whole bilayer disc first becomes a shallow bowl. Beyond a small prestretch it rolls up along one
direction, because a bowl must stretch and a roll need not. Plate theory knows this well: two equal
curvatures part at a critical mismatch.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import bilayer

specimen = bilayer.paper_specimen().with_layer("kirigami", pattern=None)
specimen = replace(specimen, mesh=bilayer.MeshSize(0.006))
stretches = [1.0005, 1.001, 1.002, 1.003, 1.005, 1.01, 1.02]
result = bilayer.solve(specimen.with_milestones(stretches), "dshell")

# %%
# The widths of the body along its principal axes say it (root mean squares). Their ratio is that of
# the flat mesh as long as the shape is a bowl, and falls when it rolls up, whatever the direction.


def ratio_of(points):
    """Return the second largest width of points over the largest one."""
    return np.divide(*np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1::-1])


flat = ratio_of(result["reference_position"].values)
ratios = np.array([ratio_of(shape) / flat for shape in result["position"].values])
print(ratios.round(4))
assert abs(ratios[0] - 1) < 1e-4  # a bowl
assert ratios[-1] < 0.97  # a roll
assert (result["unstable_modes"] == 0).all()

# %%
# The first shape and the last:

shapes = bilayer.draw_isometric(result.isel(prestretch=[0, -1]))

# %%
figure, axes = plt.subplots(figsize=(4.8, 3.4), layout="constrained")
axes.plot(100 * (np.array(stretches) - 1), ratios, "o-")
axes.set(xlabel="prestretch - 1 (%)", ylabel="width across over width along")
figure.savefig("loss_of_symmetry.png")
