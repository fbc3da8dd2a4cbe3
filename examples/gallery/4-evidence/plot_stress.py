"""
Stress in the kirigami layer
============================

Fields are computed from a result when they are asked for: strains and stresses of each layer at
three heights, energies, curvatures. Both solvers have the same ones.
"""

from dataclasses import replace

import numpy as np

import bilayer

specimen = replace(bilayer.paper_specimen().with_milestones([1.06]), mesh=bilayer.MeshSize(0.005))
result = bilayer.solve(specimen, "dshell")
fields = bilayer.fields(result)

# %%
# The energies of the layers are the sums over their faces, and are those that the solver minimised.

energy = (fields["energy_density"] * fields["natural_volume"]).sum("face")
print((1e3 * energy).squeeze().to_pandas().round(4))
assert np.isclose(float(energy.sum()), float(result["energy"].sum()), rtol=1e-6)

# %%
figure = bilayer.draw_shapes(
    result, field=bilayer.scalar_field(fields, "principal_stress.kirigami.top.first")
)
bilayer.save_figure(figure, "stress.png")
