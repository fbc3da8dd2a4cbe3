"""
Turned over
===========

The kirigami layer may lie below the substrate. Without weight, such a specimen takes the mirrored
shape. With its weight, lying this way round or that is not the same.
"""

from dataclasses import replace

import matplotlib.pyplot as plt

import bilayer

upright = replace(bilayer.paper_specimen().with_milestones([1.06]), mesh=bilayer.MeshSize(0.006))
over = replace(upright, layers=upright.layers[::-1])
mesh = bilayer.generate_mesh(upright)


def height(specimen):
    """Return the height of the dome, mm."""
    return 1e3 * bilayer.solve(specimen, "dshell", mesh=mesh)["height"].item()


# %%
# Without weight the two heights agree:

free = [height(upright), height(over)]
assert abs(free[0] - free[1]) < 1e-3

# %%
# Under a tenth of the earth's gravity they do not: the weight opens a bowl that is held at its
# lowest point, and closes a dome that is held at its top.

heavy = [height(replace(specimen, gravity=1.0)) for specimen in (upright, over)]
print(f"kirigami above {heavy[0]:.2f} mm, below {heavy[1]:.2f} mm, without weight {free[0]:.2f} mm")
assert abs(heavy[0] - heavy[1]) > 0.5

# %%
figure, axes = plt.subplots(figsize=(4.2, 3.2), layout="constrained")
axes.bar(["no weight", "kirigami\nabove", "kirigami\nbelow"], [free[0], *heavy], color="#4477aa")
axes.set_ylabel("height (mm)")
figure.savefig("turned_over.png")
