"""
The released shapes
===================

Figures 2 and 3 of the paper: the dome at four of its eight prestretches, seen from the side and
from above. The discrete shell takes seconds. The finite-element model (``bilayer.solve(specimen,
"fenics")``) gives the same pictures in a minute.
"""

import bilayer

specimen = bilayer.paper_specimen().with_milestones([1.03, 1.06, 1.15, 1.24])
result = bilayer.solve(specimen, "dshell")
print(result[["height", "sphere_radius", "quality", "unstable_modes"]].to_dataframe())

# %%
# The height at 1.06 on the default mesh is 17.5 mm. All shapes are stable.

height = float(result["height"].sel(prestretch=1.06))
assert abs(height - 17.48e-3) < 0.1e-3
assert (result["unstable_modes"] == 0).all()

# %%
figure = bilayer.draw_shapes(result)
bilayer.save_figure(figure, "shapes.png")
