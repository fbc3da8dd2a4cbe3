"""The uncut disc of the ladder with the finite-element model, scaled as in `bilayers`. SI units."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from mpi4py import MPI

from bilayer import PlanarMesh, Specimen, solve
from bilayer.errors import ComputationError
from bilayer.mesh.generation import generate_mesh
from bilayer.results.schema import result_mesh
from bilayer.specimen.support import choose_nodes_inside
from dshell.models.hinge_rest_state import specimen_sections
from fenics_model import SolidSettings
from fenics_model.branches.buckling_modes import least_stiffness
from fenics_model.path.load_schedule import LoadSchedule
from fenics_model.release.specimen_solid import held_points, make_solid
from verification import bilayers
from verification.bilayers import RADIUS, Cap
from verification.solid_problem import equilibria, load_path, newton_of

CENTRE = 0.02
"""Radius of what is fitted for the curvatures at the centre, m."""

AXIS = 0.02
"""By how much the mismatch along y is less, so that a rolled disc knows about which axis."""


def disc(mismatches: Sequence[float], size: float, less_along_y: float = 0.0) -> Specimen:
    """The uncut disc at mismatches S, ascending; along y less by a share."""
    stretches = [bilayers.stretch_of(mismatch) for mismatch in mismatches]
    pairs = [(s, 1 + (s - 1) * (1 - less_along_y)) for s in stretches]
    return bilayers.ladder_disc(size=size).with_milestones(pairs)


def laminate_curvature(mismatch: float) -> float:
    """k0 of the uncut disc at S, by laminate theory, 1/m."""
    stretch = bilayers.stretch_of(mismatch)
    section = specimen_sections(bilayers.ladder_disc(), (stretch, stretch))[1]
    return float(section.curvature[0])


def stable(result: xr.Dataset) -> xr.Dataset:
    """Return a result each of whose shapes is reached and stable."""
    if not result["converged"].values.all() or result["unstable_modes"].values.any():
        raise ComputationError(f"not every shape is stable; {result.attrs['stop_reason']}")
    return result


def scaled_caps(mismatches: Sequence[float], size: float) -> list[Cap]:
    """The caps at mismatches S below the loss of their symmetry."""
    result = stable(solve(disc(mismatches, size), "fenics", SolidSettings(imperfection=0.0)))
    caps = []
    for mismatch, shape in zip(mismatches, result["position"].values, strict=True):
        scale = mismatch / laminate_curvature(mismatch)
        radius, height = _profile(result, shape)
        terms = np.polynomial.polynomial.polyfit((radius / RADIUS) ** 2, height, 4)
        sag = terms[1:].sum()
        caps.append(Cap(*(2 * abs(term) / RADIUS**2 * scale for term in (sag, terms[1]))))
    return caps


def _profile(result: xr.Dataset, shape) -> tuple[np.ndarray, np.ndarray]:
    """Distance from the axis on the flat disc, and height along the axis, of each node, m."""
    mesh = result_mesh(result)
    rim = shape[mesh.rim_nodes]
    normal = np.linalg.svd(rim - rim.mean(axis=0))[2][2]
    return np.linalg.norm(mesh.points, axis=1), (shape - rim.mean(axis=0)) @ normal


def loss_of_symmetry(mismatches: Sequence[float], size: float) -> float:
    """The S at which the least stiffness of the cap falls to 0: a parabola through those before."""
    stiffness = cap_stiffness(mismatches, size)
    zeros = np.roots(np.polyfit(mismatches, stiffness, 2))
    beyond = [zero.real for zero in zeros if np.isreal(zero) and zero.real > max(mismatches)]
    if not beyond:
        raise ComputationError("the least stiffness of the cap does not fall to 0")
    return float(min(beyond))


def cap_stiffness(mismatches: Sequence[float], size: float) -> list[float]:
    """Least eigenvalue k of K d = k M d of the cap at each S, Pa/m2."""
    specimen = disc(mismatches, size)
    mesh = generate_mesh(specimen)
    body = make_solid(specimen, mesh, SolidSettings(imperfection=0.0), MPI.COMM_WORLD)
    solid, loads = body.solid, LoadSchedule(specimen.prestretch.milestones)
    held = held_points(choose_nodes_inside(mesh.points), solid.mesh.volume)
    found = []
    with newton_of(solid, solid.held_points(held)) as newton:
        path = load_path(newton, lambda parameter: body.load(loads.place(parameter)), 0.001)
        for point in equilibria(path, loads.milestones):
            with newton.factorise(point.state) as factors:
                found.append(least_stiffness(factors, newton.mass, point.state.values))
    return found


def two_fold(mismatch: float, size: float) -> xr.Dataset:
    """The uncut disc at S beyond the loss of symmetry, come to without an imperfection."""
    specimen = disc([0.97 * mismatch, mismatch], size)
    return stable(solve(specimen, "fenics", SolidSettings(imperfection=0.0)))


def rolled_curvature(mismatch: float, size: float) -> float:
    """The larger principal curvature at the centre of the uncut disc at S, over k0.

    The shell's shapes are the initial guesses. Load steps would take 300 iterations, because the
    roll's axis turns nearly freely.
    """
    specimen = disc([mismatch], size, AXIS)
    mesh = generate_mesh(specimen)
    shell = solve(specimen, "dshell", mesh=mesh)
    result = stable(solve(specimen, "fenics", mesh=mesh, start=shell))
    curvatures = centre_curvatures(mesh, result["position"].values[-1])
    return float(curvatures.max() / laminate_curvature(mismatch))


def centre_curvatures(mesh: PlanarMesh, shape) -> np.ndarray:
    """The principal curvatures at the centre, 1/m, without their sign.

    Of the surface x(X, Y) of fourth degree fitted to the nodes around it: the eigenvalues of the
    second fundamental form relative to the first.
    """
    near = np.linalg.norm(mesh.points, axis=1) < CENTRE
    X, Y = mesh.points[near].T / CENTRE
    powers = [(i, j) for i in range(5) for j in range(5 - i)]
    columns = np.column_stack([X**i * Y**j for i, j in powers])
    terms = dict(zip(powers, np.linalg.lstsq(columns, shape[near], rcond=None)[0], strict=True))
    along = np.array([terms[1, 0], terms[0, 1]]) / CENTRE
    second = np.array([[2 * terms[2, 0], terms[1, 1]], [terms[1, 1], 2 * terms[0, 2]]]) / CENTRE**2
    normal = np.cross(*along)
    bending = second @ normal / np.linalg.norm(normal)
    return np.abs(np.linalg.eigvals(np.linalg.solve(along @ along.T, bending)))
