"""
Constants from a tensile test
=============================

Uniaxial loading of VHB 4910 at 0.01 1/s, from the public data set Chongran-Zhao/VHB4910_data
(smoothed and thinned). ``fit`` finds the constants of a law, with their 95 % intervals.
"""

import sys
from pathlib import Path

import bilayer

DATA = Path(sys.argv[0]).resolve().parent / "vhb4910_uniaxial.csv"
measured = bilayer.read_measurement(DATA, "uniaxial")
fits = [bilayer.fit([measured], law) for law in ("mooney-rivlin", "yeoh", "ogden-1")]

# %%
for found in fits:
    print(f"{found.law_name}: rms residual {100 * found.rms:.2f} % of the largest stress")
    for constant in found.constants:
        low, high = constant.interval
        print(f"  {constant.name} = {constant.value:.4g} {constant.unit} ({low:.4g} to {high:.4g})")

# %%
# One term of Ogden's law follows the test best, up to a stretch of 2. The law goes straight into a
# layer.

assert min(fits, key=lambda found: found.aicc) is fits[2]
assert fits[2].rms < 0.02
specimen = bilayer.paper_specimen().with_layer("substrate", material=fits[2].law)
assert specimen.layer("substrate").material is fits[2].law

# %%
figure = bilayer.draw_fits(fits)
bilayer.save_figure(figure, "material_fit.png")
