"""
A cross on a square
===================

The two-layer version of published bistable sheets: a stretched square of 40 mm with a cross bonded
onto it. The file is ``examples/square_cross.toml``.
"""

import sys
from pathlib import Path

import bilayer

EXAMPLES = Path(sys.argv[0]).resolve().parents[2]
specimen = bilayer.read_specimen(EXAMPLES / "square_cross.toml", ["mesh.size='3 mm'"])
result = bilayer.solve(specimen.with_milestones([1.05, 1.1, 1.15, 1.2]), "dshell")
print(result[["height", "unstable_modes"]].to_dataframe())

# %%
# A square with a cross has a fourfold symmetry. The shape keeps it: the spans along x and y agree.

span = result["span"].isel(prestretch=-1)
assert abs(float(span.sel(xyz="x") / span.sel(xyz="y")) - 1) < 1e-3
assert (result["unstable_modes"] == 0).all()

# %%
figure = bilayer.draw_isometric(result)
bilayer.save_figure(figure, "cross.png")
