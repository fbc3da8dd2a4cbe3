"""Strain and Cauchy stress of a law from the deformation, in axes that turn with the material.

With F = R U, the Cauchy stress sigma is told as R^T sigma R: its components are along the axes of
the flat sheet as they have turned with the material, and its principal values are those of sigma.
"""

from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mechanics.memory import ELASTIC, Memory
from bilayer.specimen.materials import Hyperelastic, Law, LinearElastic

Array = NDArray[np.float64]

_IDENTITY = np.eye(3)


@singledispatch
def green_strain(law: Law, stretch: Array, prestretch: Array) -> Array:
    """Return the elastic Green strain, (..., 3, 3): the strain that the law answers to.

    Parameters
    ----------
    law : Law
        Of the layer.
    stretch : (..., 3, 3) array of float
        C from the natural state.
    prestretch : (3, 3) array of float
        From the natural state to the flat bonded one, symmetric, of determinant 1.
    """
    return (stretch - _IDENTITY) / 2


@green_strain.register
def _(law: LinearElastic, stretch: Array, prestretch: Array) -> Array:
    """Add the initial strain to the strain from the bonded state, as eqs. 8-9 of the paper do."""
    poisson = law.poisson_ratio
    initial = np.zeros((3, 3))
    initial[:2, :2] = prestretch[:2, :2] - np.eye(2)
    initial[2, 2] = -poisson / (1 - poisson) * np.trace(initial)
    return (_from_bonded(stretch, prestretch) - _IDENTITY) / 2 + initial


@singledispatch
def cauchy_stress(
    law: Law,
    stretch: Array,
    prestretch: Array,
    pressure: Array | None,
    memory: Memory = ELASTIC,
) -> Array:
    """Return the Cauchy stress R^T sigma R, Pa, (..., 3, 3).

    Parameters
    ----------
    law, stretch, prestretch
        As those of `green_strain`.
    pressure : (...) array of float or None
        Mean of the principal stresses of a hyperelastic law, Pa (of a linear one: of those of its
        own stress, with the flat bonded state as reference); None: plane stress, so that the
        stress across the layer is 0.
    memory : Memory
        Of a layer that relaxes; its pull, (..., 3, 3), has the flat bonded state as reference.

    Raises
    ------
    InputError
        There is no stress of such a law.

    Examples
    --------
    A layer stretched by 1.1 in its plane, the volume kept: 2 C10 (l^2 - l^-4) in its plane.

    >>> import numpy as np
    >>> from bilayer import NeoHookean
    >>> stretch = np.diag([1.21, 1.21, 1.1**-4])
    >>> stress = cauchy_stress(NeoHookean(10e3), stretch, np.eye(3), None)
    >>> np.round(np.diag(stress), 6).tolist() == np.round(20e3 * np.diag(
    ...     [1.21 - 1.1**-4, 1.21 - 1.1**-4, 0]).diagonal(), 6).tolist()
    True
    """
    raise InputError(f"law = {type(law).__name__}: there is no Cauchy stress of it")


@cauchy_stress.register
def _(
    law: Hyperelastic,
    stretch: Array,
    prestretch: Array,
    pressure: Array | None,
    memory: Memory = ELASTIC,
) -> Array:
    """Return 2/J dev((w_1 + I1 w_2) C - w_2 C^2) of the isochoric C, and the pressure.

    A dead stress P adds 1/J dev(U P U), U that of the isochoric C.
    """
    jacobian = np.sqrt(np.linalg.det(stretch))
    isochoric = stretch / np.cbrt(jacobian**2)[..., None, None]
    squared = isochoric @ isochoric
    I1 = _trace(isochoric)
    I2 = (I1**2 - _trace(squared)) / 2
    by_I1, by_I2 = (np.asarray(slope) + np.zeros_like(I1) for slope in law.slopes(I1, I2).first)
    change = (by_I1 + I1 * by_I2)[..., None, None] * isochoric - by_I2[..., None, None] * squared
    inverse = np.linalg.inv(prestretch)
    root = _root(isochoric)
    dead = root @ inverse @ memory.pull @ inverse @ root
    deviator = _deviator(2 * memory.factor * change + dead) / jacobian[..., None, None]
    mean = -deviator[..., 2, 2] if pressure is None else pressure
    return np.asarray(deviator + mean[..., None, None] * _IDENTITY)


@cauchy_stress.register
def _(
    law: LinearElastic,
    stretch: Array,
    prestretch: Array,
    pressure: Array | None,
    memory: Memory = ELASTIC,
) -> Array:
    """Push the linear stress forward from the flat bonded state: U S U / J with F = R U."""
    bonded = _from_bonded(stretch, prestretch)
    strain = green_strain(law, stretch, prestretch)
    own = _deviator(2 * memory.factor * law.shear_modulus * strain + memory.pull)
    mean = -own[..., 2, 2] if pressure is None else pressure
    own = own + mean[..., None, None] * _IDENTITY
    root = _root(bonded)
    jacobian = np.sqrt(np.linalg.det(bonded))[..., None, None]
    return np.asarray(root @ own @ root / jacobian)


def _from_bonded(stretch: Array, prestretch: Array) -> Array:
    """Return C from the flat bonded state, given C from the natural one."""
    inverse = np.linalg.inv(prestretch)
    return np.asarray(inverse @ stretch @ inverse)


def _root(tensors: Array) -> Array:
    """Return the square root of symmetric tensors."""
    values, axes = np.linalg.eigh(tensors)
    return np.asarray((axes * np.sqrt(values)[..., None, :]) @ np.swapaxes(axes, -1, -2))


def _trace(tensors: Array) -> Array:
    return np.asarray(np.einsum("...ii", tensors))


def _deviator(tensors: Array) -> Array:
    return np.asarray(tensors - _trace(tensors)[..., None, None] / 3 * _IDENTITY)
