"""
A pattern computed in Python
============================

Any polygon of shapely can be a pattern. Here three spiral arms are kept of the kirigami layer. It
has no mirror symmetry, and neither has the shape.
"""

from dataclasses import replace

import numpy as np
import shapely

import bilayer

turns = np.linspace(0.0, 2 * np.pi, 60)
arms = []
for start in (0.0, 2 * np.pi / 3, 4 * np.pi / 3):
    radius = 0.006 + 0.027 * turns / turns[-1]
    angle = start + 0.5 * turns
    line = shapely.LineString(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]))
    arms.append(line.buffer(0.004))
kept = shapely.union_all([*arms, shapely.Point(0, 0).buffer(0.010)]).simplify(2e-4)

specimen = bilayer.paper_specimen()
specimen = specimen.with_layer("kirigami", pattern=bilayer.Pattern.from_geometry(kept))
specimen = replace(specimen.with_milestones([1.03, 1.06]), mesh=bilayer.MeshSize(0.006))
mesh = bilayer.generate_mesh(specimen)
result = bilayer.solve(specimen, "dshell", mesh=mesh)

# %%
# The kirigami covers as much of the mesh as of the drawing.

corners = mesh.points[mesh.triangles]
first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
areas = 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
assert np.isclose(areas[mesh.region == 1].sum(), kept.area, rtol=5e-3)
assert (result["converged"] == 1).all()

# %%
figure = bilayer.draw_shapes(result)
bilayer.save_figure(figure, "own_pattern.png")
