"""Plane-stress laws: derivatives, closed forms (ladder, rung 1), the eliminated thickness."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from verification import shell_states
from verification.laws import LAW_CASES

from bilayer import Gent, InputError, LinearElastic, MooneyRivlin, NeoHookean, Ogden
from dshell.materials import plane_stress
from dshell.materials.plane_stress import plane_stress_law

C10, C01 = 4839.1, 14536.0  # Pa, the substrate of the verification ladder
COMPRESSIBLE = MooneyRivlin(C10, C01, 1.0392e-6)
LAWS = {
    "incompressible": MooneyRivlin(C10, C01),
    "compressible": COMPRESSIBLE,
    "soft in volume": MooneyRivlin(C10, C01, 5e-5),
    "neo-Hookean": NeoHookean(C10),
    "linear": LinearElastic(116_250.0, 0.3),
    **{
        f"{name}, {kind}": case.compressible(d1)
        for name in ("yeoh", "gent", "arruda-boyce", "ogden")
        for case in [LAW_CASES[name]]
        for kind, d1 in {"incompressible": 0.0, "compressible": 1e-6, "soft": 2e-5}.items()
    },
}
PRESTRETCH = np.array([[1.2, 0.05], [0.05, 0.9]])[:, :, None]
UNSTRETCHED = np.eye(2)[:, :, None]


@pytest.fixture(params=LAWS.values(), ids=LAWS)
def law(request):
    return plane_stress_law(request.param)


@pytest.fixture
def strain():
    return np.random.default_rng(0).uniform(-0.15, 0.25, (3, 40))


def differences(function, strain, step=1e-4):
    columns = []
    for row in np.eye(3)[:, :, None] * step:
        near = function(strain + row) - function(strain - row)
        far = function(strain + 2 * row) - function(strain - 2 * row)
        columns.append((8 * near - far) / (12 * step))
    return np.stack(columns, axis=-2)


def test_stress_is_the_derivative_of_the_energy(law, strain):
    stress = law.at(strain, PRESTRETCH).stress()
    expected = differences(lambda e: law.at(e, PRESTRETCH).energy(), strain)
    assert np.abs(stress - expected).max() < 1e-7 * np.abs(stress).max()


def test_tangent_is_the_derivative_of_the_stress(law, strain):
    tangent = law.at(strain, PRESTRETCH).tangent()
    expected = differences(lambda e: law.at(e, PRESTRETCH).stress(), strain)
    assert np.abs(tangent - expected).max() < 1e-7 * np.abs(tangent).max()
    assert np.allclose(tangent, tangent.transpose(1, 0, 2), rtol=1e-12)


def test_unstretched_material_has_the_small_strain_stiffness(law, request):
    material = LAWS[request.node.callspec.id]
    E, nu = material.young_modulus, material.poisson_ratio
    expected = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    rest = law.at(np.zeros((3, 1)), UNSTRETCHED)
    assert rest.energy() == pytest.approx([0], abs=1e-9)
    assert rest.stress()[:, 0] == pytest.approx([0] * 3, abs=1e-9)
    tangent = rest.tangent()[:, :, 0]
    assert np.abs(tangent - expected).max() < 1e-9 * E


@pytest.mark.parametrize(("stretch", "expected"), [(1.06, 6307.92), (1.24, 19_530.72)])
def test_uniaxial_nominal_stress(stretch, expected):
    """P = 2 (l - l^-2) (C10 + C01 / l), pulled along x, free along y: l_y = l^(-1/2)."""
    law = plane_stress_law(LAWS["incompressible"])
    strain = np.array([[(stretch**2 - 1) / 2], [(1 / stretch - 1) / 2], [0]])
    second_piola = law.at(strain, UNSTRETCHED).stress()
    closed = 2 * (stretch - stretch**-2) * (C10 + C01 / stretch)
    assert stretch * second_piola[0, 0] == pytest.approx(closed, rel=1e-6)
    assert closed == pytest.approx(expected, abs=0.01)
    assert second_piola[1:, 0] == pytest.approx([0, 0], abs=1e-6)


@pytest.mark.parametrize(("stretch", "expected"), [(1.06, 14_037.14), (1.24, 60_612.61)])
def test_equibiaxial_cauchy_stress_of_a_prestretch(stretch, expected):
    """Cauchy = 2 (l^2 - l^-4) (C10 + C01 l^2): in the bonded state, per natural volume."""
    law = plane_stress_law(LAWS["incompressible"])
    stress = law.at(np.zeros((3, 1)), stretch * UNSTRETCHED).stress()
    closed = 2 * (stretch**2 - stretch**-4) * (C10 + C01 * stretch**2)
    assert stress[:2, 0] == pytest.approx([closed] * 2, rel=1e-6)
    assert closed == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("name", ["incompressible", "compressible"])
def test_prestretch_is_a_change_of_the_natural_state(name, strain):
    """Strain from the bonded state on top of S feels like the whole strain from the natural one."""
    law = plane_stress_law(LAWS[name])
    S = PRESTRETCH[:, :, 0]
    x, y, g = strain
    C = np.moveaxis(np.array([[1 + 2 * x, g], [g, 1 + 2 * y]]), 2, 0)
    E = (S @ C @ S - np.eye(2)) / 2
    whole = np.stack([E[:, 0, 0], E[:, 1, 1], 2 * E[:, 0, 1]])
    on_top = law.at(strain, PRESTRETCH).energy()
    assert on_top == pytest.approx(law.at(whole, UNSTRETCHED).energy())


@pytest.mark.parametrize("stretch", [1.06, 1.24])
@pytest.mark.parametrize("case", LAW_CASES.values(), ids=LAW_CASES)
def test_closed_forms_of_every_law(case, stretch):
    """Rung 24: uniaxial, equibiaxial and planar tension."""
    assert shell_states.uniaxial_stress(case.law, stretch) == pytest.approx(
        case.uniaxial_nominal(stretch), rel=1e-9
    )
    assert shell_states.equibiaxial_stress(case.law, stretch) == pytest.approx(
        case.equibiaxial_cauchy(stretch), rel=1e-9
    )
    assert shell_states.planar_stress(case.law, stretch) == pytest.approx(
        case.planar_nominal(stretch), rel=1e-9
    )


@pytest.mark.parametrize("d1", [0.0, 1e-6])
def test_ogden_with_the_exponents_of_mooney_rivlin_is_mooney_rivlin(strain, d1):
    one = plane_stress_law(Ogden([2 * C10, 2 * C01], [2, -2], d1)).at(strain, PRESTRETCH)
    other = plane_stress_law(MooneyRivlin(C10, C01, d1)).at(strain, PRESTRETCH)
    for found, expected in (
        (one.energy(), other.energy()),
        (one.stress(), other.stress()),
        (one.tangent(), other.tangent()),
    ):
        assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()


def in_plane_stretch(stretch):
    """Green strain of an equal stretch along both axes, (3, 1)."""
    return np.array([[(stretch**2 - 1) / 2]] * 2 + [[0.0]])


def test_gent_is_out_of_reach_beyond_its_limit():
    law = plane_stress_law(Gent(4e4, 3.0))  # equibiaxial: locks at 1.7
    assert np.isfinite(law.at(in_plane_stretch(1.7), UNSTRETCHED).energy()[0])
    assert law.at(in_plane_stretch(1.75), UNSTRETCHED).energy()[0] == np.inf


def test_gent_that_would_lock_at_constant_volume_gives_way():
    """Of little bulk modulus, it is stretched farther; against a scalar minimisation."""
    mu, jm, d1 = 4e4, 3.0, 3e-5
    law, stretch = plane_stress_law(Gent(mu, jm, d1)), 1.75

    def energy(third):
        J = stretch**2 * third
        left = 1 - ((2 * stretch**2 + third**2) * J ** (-2 / 3) - 3) / jm
        return -mu * jm / 2 * np.log(left) + (J - 1) ** 2 / d1 if left > 0 else 1e30

    least = minimize_scalar(energy, bounds=(0.4, 1.0), method="bounded", options={"xatol": 1e-10})
    found = law.at(in_plane_stretch(stretch), UNSTRETCHED).energy()[0]
    assert found == pytest.approx(least.fun, rel=1e-9)


def test_thickness_is_the_one_of_least_energy():
    """W of the law in three dimensions, minimised over C33 by another program."""
    law = plane_stress_law(COMPRESSIBLE)
    strain = np.array([[0.12], [-0.07], [0.05]])
    C = np.array([[1.24, 0.05], [0.05, 0.86]])

    def energy(c33):
        full = np.block([[C, np.zeros((2, 1))], [np.zeros((1, 2)), c33]])
        J = np.sqrt(np.linalg.det(full))
        first = np.trace(full)
        second = (first**2 - np.trace(full @ full)) / 2
        isochoric = C10 * (first * J ** (-2 / 3) - 3) + C01 * (second * J ** (-4 / 3) - 3)
        return isochoric + (J - 1) ** 2 / COMPRESSIBLE.d1

    least = minimize_scalar(energy, bounds=(0.5, 2), method="bounded", options={"xatol": 1e-10})
    assert law.at(strain, UNSTRETCHED).energy()[0] == pytest.approx(least.fun, rel=1e-10)


def test_a_fibre_turned_inside_out_is_out_of_reach():
    law = plane_stress_law(LAWS["compressible"])
    turned = np.array([[-0.6], [0.1], [0.0]])
    assert law.at(turned, UNSTRETCHED).energy()[0] == np.inf


def test_linear_prestress_is_hookes():
    """The corrected eq. 8: E eps / (1 - nu)."""
    law = plane_stress_law(LAWS["linear"])
    stress = law.at(np.zeros((3, 1)), 1.03 * UNSTRETCHED).stress()
    assert stress[:, 0] == pytest.approx([116_250 * 0.03 / 0.7] * 2 + [0])


def test_other_materials_are_refused():
    with pytest.raises(InputError, match="no plane-stress law"):
        plane_stress_law("rubber")


def iterations_of_the_volume(law, strain, monkeypatch):
    counted = []
    derivatives = plane_stress.Expansion.volume_derivatives

    def counting(expansion):
        counted.append(expansion)
        return derivatives(expansion)

    monkeypatch.setattr(plane_stress.Expansion, "volume_derivatives", counting)
    law.at(strain, PRESTRETCH)
    return len(counted) - 1  # the first makes the guess


def test_a_stiff_volume_is_found_at_once(strain, monkeypatch):
    law = plane_stress_law(COMPRESSIBLE)
    assert iterations_of_the_volume(law, strain, monkeypatch) <= 2  # from r = 1 it takes 4


def test_nobody_waits_for_the_volume_of_what_is_turned_inside_out(strain, monkeypatch):
    law = plane_stress_law(COMPRESSIBLE)
    turned = np.column_stack([strain, [-0.9, 0.4, 0.0]])
    assert law.at(turned, PRESTRETCH).energy()[-1] == np.inf
    assert iterations_of_the_volume(law, turned, monkeypatch) <= 2
