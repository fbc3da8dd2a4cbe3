"""
The planar mesh
===============

Figure 1 of the paper: the flat disc, and where the kirigami layer lies on it. Both solvers work on
this mesh. The cut edges are edges of the mesh, so the bare area is exact but for the rim, which is
a polygon.
"""

import numpy as np

import bilayer

specimen = bilayer.paper_specimen()
mesh = bilayer.generate_mesh(specimen)

corners = mesh.points[mesh.triangles]
first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
areas = 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
bare = areas[mesh.region == 0].sum()

# %%
# Five cutouts of 0.3 rad, from 8 mm to the rim at 40 mm:

exact = 5 * 0.3 / 2 * (0.040**2 - 0.008**2)
print(f"bare area {1e6 * bare:.1f} mm2, exact {1e6 * exact:.1f} mm2")
assert np.isclose(bare, exact, rtol=2e-3)

# %%
figure = bilayer.draw_mesh(mesh)
bilayer.save_figure(figure, "mesh.png")
