"""What a layer that relaxes remembers: finite linear viscoelasticity with internal stresses.

The stress S that an energy has by some strain e becomes

    S(t) = g_inf S0(e(t)) + sum H_i,    H_i(t) = int g_i exp(-(t - s) / tau_i) dS0/ds ds,

S0 that of the instantaneous law. With S0 linear in time over a step dt,

    H_i <- exp(-x_i) H_i + g_i a_i (S0_new - S0),    x_i = dt / tau_i,  a_i = (1 - exp(-x_i)) / x_i,

so at the end of the step S = c S0(e) + P, where c = g_inf + sum g_i a_i and P does not depend on e:
the layer is that of the law with another stiffness and a dead stress. It has the energy
c W0(e) + P : e, and a step in time is a search for an equilibrium as any other.

Which strain and stress these are is the business of each solver.

Source: J. C. Simo, *On a fully three-dimensional finite-strain viscoelastic damage model*, Computer
Methods in Applied Mechanics and Engineering 60 (1987) 153-173, and G. A. Holzapfel, *Nonlinear
Solid Mechanics* (2000), section 6.10, with the update that is exact for a strain rate held.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bilayer.specimen.relaxation import PronySeries

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Memory:
    """The part of a step that does not depend on the strain at its end.

    Parameters
    ----------
    factor : float
        c.
    pull : (..., k) array of float
        P, Pa; k faces or cells.
    """

    factor: float
    pull: Array

    def part(self, faces: slice) -> "Memory":
        """Return that of some of the faces."""
        return replace(self, pull=self.pull[..., faces])


ELASTIC = Memory(1.0, np.zeros((3, 3)))
"""That of a layer which remembers nothing, as a tensor."""


@dataclass(frozen=True, eq=False)
class History:
    """The state of a layer that relaxes at some time.

    Parameters
    ----------
    series : PronySeries
        g_i and tau_i.
    stress : (...) array of float
        S0, Pa.
    inner : (n, ...) array of float
        H_i, Pa.
    """

    series: PronySeries
    stress: Array
    inner: Array

    @classmethod
    def held(cls, series: PronySeries, stress: Array, hold: float) -> "History":
        """Return that of a layer that has been stretched at once and held for so long, s."""
        left = series.shares * np.exp(-hold / series.times)
        return cls(series, stress, np.multiply.outer(left, stress))

    def memory(self, step: float) -> Memory:
        """Return what a step of so many seconds begins with; 0 s is an instantaneous one."""
        decay, gain = self._over(step)
        pull = np.tensordot(decay, self.inner, axes=1) - gain.sum() * self.stress
        return Memory(self.series.relaxed_share + float(gain.sum()), pull)

    def after(self, step: float, stress: Array) -> "History":
        """Return the history at the end of a step, where S0 is a given one."""
        decay, gain = self._over(step)
        faded = decay.reshape(-1, *(1,) * stress.ndim) * self.inner
        gained = np.multiply.outer(gain, stress - self.stress)
        return History(self.series, stress, faded + gained)

    def _over(self, step: float) -> tuple[Array, Array]:
        """Return exp(-x_i) and g_i a_i of a step."""
        x = step / self.series.times
        mean = -np.expm1(-x) / np.where(x > 0, x, 1.0)
        return np.exp(-x), self.series.shares * np.where(x > 0, mean, 1.0)
