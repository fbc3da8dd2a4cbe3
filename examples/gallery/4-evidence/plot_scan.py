"""
A scan of the part
==================

``compare_scan`` lays the points of a scan onto every shape of a result. It says which prestretch
fits best and how far the part is away. The scan here is made up, so that the answer is known: a
shape of another mesh at 1.06, turned and moved, with noise of 0.1 mm.
"""

from dataclasses import replace

import numpy as np

import bilayer

specimen = bilayer.paper_specimen()
result = bilayer.solve(
    replace(specimen.with_milestones([1.03, 1.06, 1.09]), mesh=bilayer.MeshSize(0.005)), "dshell"
)

other = replace(specimen.with_milestones([1.06]), mesh=bilayer.MeshSize(0.004))
points = bilayer.solve(other, "dshell")["position"].values[0]
chance = np.random.default_rng(1)
turn = np.linalg.qr(chance.normal(size=(3, 3)))[0]
turn *= np.sign(np.linalg.det(turn))
points = points @ turn.T + [0.1, 0.2, 0.3] + chance.normal(scale=1e-4, size=points.shape)
scan = bilayer.Cloud("made up", points)

# %%
matches = bilayer.compare_scan(result, scan)
for match in matches:
    print(f"{match.title}: rms {1e3 * match.rms:.3f} mm, cost {1e3 * match.cost:.3f} mm")
best = min(matches, key=lambda match: match.cost)
assert best is matches[1]
assert best.rms < 0.5e-3

# %%
figure = bilayer.draw_scan(scan, best)
bilayer.save_figure(figure, "scan.png")
