"""
A strip that snaps through
==========================

A plastic strip is clamped at both ends and buckled by pushing them together. Its middle is then
pushed down through the plane, and back (``examples/snapping_strip.toml``). Displacement control
follows the force through both of its limit points, where a force alone would snap.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import bilayer

EXAMPLES = Path(sys.argv[0]).resolve().parents[2]
specimen = bilayer.read_specimen(EXAMPLES / "snapping_strip.toml", ["mesh.size='3 mm'"])
result = bilayer.solve(specimen, "dshell")

# %%
# The shapes at 2 mm up and 2 mm down are mirror images: the forces are opposite.

path = result["displacement_poke"].values
force = result["response_poke"].values
up, down = (int(abs(path - place).argmin()) for place in (2e-3, -2e-3))
print(f"force at +2 mm {1e3 * force[up]:.1f} mN, at -2 mm {1e3 * force[down]:.1f} mN")
assert abs(force[up] + force[down]) < 0.01 * abs(force[up])
assert abs(path[-1] - path[1]) < 1e-6  # back in the shape that it came from
assert (result["converged"] == 1).all()

# %%
figure, axes = plt.subplots(figsize=(4.8, 3.4), layout="constrained")
axes.plot(1e3 * path[1:11], 1e3 * force[1:11], "o-")  # on the way down
axes.set(xlabel="displacement of the middle (mm)", ylabel="force on it (mN)")
axes.axhline(0.0, color="0.8", zorder=0)
figure.savefig("snapping.png")
