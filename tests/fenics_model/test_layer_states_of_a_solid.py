"""The deformation of a solid's layers: uniform states, the element's rate, energies, ranks."""

import numpy as np
import pytest
from mpi4py import MPI

from bilayer import Disc, MeshSize, NeoHookean, Prestretch, Specimen, generate_mesh
from bilayer.mechanics.dataset import isochoric
from bilayer.mechanics.stress import cauchy_stress, green_strain
from bilayer.specimen.layer import Layer, Response
from fenics_model.release.layer_states import layer_states
from fenics_model.release.specimen_solid import make_solid
from fenics_model.settings import SolidSettings

STRETCH = (1.2, 1.1)
LAW = NeoHookean(1e4, d1=1e-6)


def body_of(size=0.01, elements=1):
    """A disc of one law, its lower layer stretched; the upper one is cut from the top down."""
    stretched = Layer("substrate", 1e-3, LAW, response=Response("path"))
    layers = (stretched, Layer("kirigami", 5e-4, LAW))
    specimen = Specimen(Disc(0.02), layers, Prestretch((STRETCH,)), MeshSize(size))
    mesh = generate_mesh(specimen)
    settings = SolidSettings(substrate_elements=elements, kirigami_elements=elements)
    body = make_solid(specimen, mesh, settings, MPI.COMM_WORLD)
    body.prestretch(specimen, STRETCH)
    return body


@pytest.mark.mpi
@pytest.mark.parametrize("elements", [1, 2, 3])
def test_a_uniform_state(elements):
    """The bonded sheet, stretched, sheared and turned: the same strain and stress everywhere."""
    body = body_of(elements=elements)
    c, s = np.cos(0.4), np.sin(0.4)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    bonded = turn @ np.array([[1.03, 0.04, 0.0], [0.0, 0.98, 0.0], [0.0, 0.0, 0.99]])
    pressure = 321.0
    # one map of the whole body, which the two layers' thicknesses are scaled by alike
    state = body.solid.interpolate(
        lambda x: (bonded - np.eye(3)) @ x,
        *[lambda x: np.full(x.shape[1], pressure / float(body.solid.pressure_scale.value))] * 2,
    )
    for part in layer_states(body, STRETCH, state):
        layer = body.specimen.bonded_layer(part.name, STRETCH)
        natural = np.eye(3)
        natural[:2, :2] = layer.stretch
        elastic = bonded @ natural  # drawn with its natural thickness
        C = np.broadcast_to(elastic.T @ elastic, part.stretch.shape)
        assert part.stretch == pytest.approx(C, rel=1e-8, abs=1e-10)
        assert part.pressure == pytest.approx(pressure, rel=1e-8)
        strain = green_strain(LAW, part.stretch, isochoric(layer))
        assert strain == pytest.approx((C - np.eye(3)) / 2, abs=1e-8)
        J = np.linalg.det(elastic)
        B = elastic @ elastic.T / np.cbrt(J**2)
        expected = 2e4 / J * (B - np.trace(B) / 3 * np.eye(3)) + pressure * np.eye(3)
        stress = cauchy_stress(LAW, part.stretch, isochoric(layer), part.pressure)
        in_space = part.rotation @ stress @ np.swapaxes(part.rotation, -1, -2)
        assert in_space == pytest.approx(
            np.broadcast_to(expected, in_space.shape), abs=1e-8 * np.abs(expected).max()
        )
        area = body.mesh.areas[part.faces]
        assert part.volume == pytest.approx(area * layer.layer.thickness / np.prod(
            np.diag(natural)), rel=1e-9)  # fmt: skip


@pytest.mark.mpi
def test_stresses_converge_at_the_elements_rate():
    """A sheet bent to a cylinder: the error of the stress falls as the square of the edge."""
    radius, errors, sizes = 0.05, [], []
    for size, elements in ((0.008, 1), (0.004, 2)):
        body = body_of(size, elements)

        def bend(x):
            angle = x[0] / radius
            out = radius + x[2]
            return np.stack(
                [out * np.sin(angle) - x[0], 0 * x[0], out * np.cos(angle) - radius - x[2]]
            )

        state = body.solid.interpolate(bend)
        part = layer_states(body, STRETCH, state)[0]
        layer = body.specimen.bonded_layer(part.name, STRETCH)
        heights = np.array([-1.0, -0.5, 0.0]) * layer.layer.thickness
        exact = np.zeros(part.stretch.shape)
        natural = np.diag([STRETCH[0], STRETCH[1], 1.0])
        for level, z in enumerate(heights):
            own = np.diag([1 + z / radius, 1.0, 1.0]) @ natural
            exact[level] = own @ own
        stress, told = (
            cauchy_stress(LAW, C, isochoric(layer), part.pressure) for C in (part.stretch, exact)
        )
        errors.append(np.sqrt(np.mean((stress - told) ** 2)))
        sizes.append(np.sqrt(len(part.faces)))
    rate = np.log(errors[0] / errors[1]) / np.log(sizes[1] / sizes[0])
    assert rate > 1.8


@pytest.mark.mpi
def test_energies_add_up():
    body = body_of(elements=2)
    rng = np.random.default_rng(2)
    wave = rng.normal(size=(3, 3)) * 0.05
    state = body.solid.interpolate(lambda x: wave @ x + 3.0 * np.stack([x[2], x[0], x[1]]) ** 2)
    for number, part in enumerate(layer_states(body, STRETCH, state)):
        energy = body.solid.layer_energy(number, state)
        assert part.energy.sum() == pytest.approx(energy, rel=1e-10)


def test_fields_of_a_released_solid(paper_6mm, paper_6mm_solid):
    """Computed from the result; the shell's are near: stress of the kirigami to a quarter."""
    import bilayer

    fields = bilayer.fields(paper_6mm_solid.isel(prestretch=[0]))
    assert float(fields["found_again"].max()) < 1e-6
    held = (fields["energy_density"] * fields["natural_volume"]).sum("face").values
    energies = paper_6mm_solid["energy"].values[:1]
    assert held == pytest.approx(energies, rel=1e-6)
    assert held.sum() == pytest.approx(energies.sum(), rel=1e-10)
    mesh = bilayer.result_mesh(paper_6mm_solid)
    shell = bilayer.fields(bilayer.solve(paper_6mm.with_milestones([1.03]), "dshell", mesh=mesh))
    assert list(shell.data_vars) == list(fields.data_vars)
    own, other = (
        f["cauchy_stress"].sel(sheet_layer="kirigami", level="middle").values
        for f in (fields, shell)
    )
    apart = np.sqrt(np.nanmean((own - other) ** 2))
    assert apart < 0.25 * np.sqrt(np.nanmean(own**2))
