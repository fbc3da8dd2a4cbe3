"""
Petals that touch
=================

At a prestretch of about 1.28 the petals of the paper's specimen meet. By default the shape then
passes through itself, and the result says so. With ``contact="barrier"`` the petals press on each
other. The package ipctk is needed.
"""

from dataclasses import replace

import bilayer

specimen = bilayer.paper_specimen().with_milestones([1.24, 1.30, 1.36])
specimen = replace(specimen, mesh=bilayer.MeshSize(0.006))
mesh = bilayer.generate_mesh(specimen)
through = bilayer.solve(specimen, "dshell", mesh=mesh)
result = bilayer.solve(specimen, "dshell", bilayer.MorleySettings(contact="barrier"), mesh=mesh)
print(result[["contact_force", "contact_gap", "contact_crosses"]].to_dataframe())

# %%
# Before the first contact the numbers are the same to the last bit. Then a force appears, and the
# skin does not cross itself.

assert float(result["height"][0]) == float(through["height"][0])
assert float(result["contact_force"][-1]) > 0
assert not result["contact_crosses"].any()

# %%
figure = bilayer.draw_birds_eye(result)
bilayer.save_figure(figure, "contact.png")
