"""
Two stable shapes of one sheet
==============================

A bilayer sheet without cuts rolls up, and it may do so along different directions. This rectangle
rolls along its diagonal or along its shorter side. Both shapes are stable, and their energies
differ. Which one a run finds depends on its path.
"""

from dataclasses import replace

import bilayer

paper = bilayer.paper_specimen().with_layer("kirigami", pattern=None)
sheet = replace(paper, outline=bilayer.Rectangle(0.07, 0.06), mesh=bilayer.MeshSize(0.006))
mesh = bilayer.generate_mesh(sheet)

# %%
# Stretch a little more along one axis first, and go from there to the same equal prestretch.

shapes = [
    bilayer.solve(sheet.with_milestones([lead, 1.03]), "dshell", mesh=mesh)
    for lead in ((1.03, 1.0), (1.0, 1.03))
]
spans = [1e3 * shape["span"].isel(prestretch=-1) for shape in shapes]
energies = [1e3 * float(shape["energy"].isel(prestretch=-1).sum()) for shape in shapes]
for span, energy in zip(spans, energies, strict=True):
    print(f"spans {span.values.round(1)} mm, energy {energy:.4f} mJ")

# %%
# Both are stable equilibria of the same sheet at the same prestretch. Their energies differ by 1 %.

assert all(int(shape["unstable_modes"][-1]) == 0 for shape in shapes)
assert max(energies) > 1.005 * min(energies)

# %%
first = bilayer.draw_isometric(shapes[0].isel(prestretch=[-1]))
second = bilayer.draw_isometric(shapes[1].isel(prestretch=[-1]))
bilayer.save_figure(first, "stable_shapes.png")
