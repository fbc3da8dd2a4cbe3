"""Settings of the finite-element model, with their defaults."""

from dataclasses import dataclass

from bilayer.errors import InputError
from bilayer.specimen.settings import BRANCH_CHOICES, CONTACT_CHOICES, setting
from bilayer.specimen.specimen import KIRIGAMI_LAYER, SUBSTRATE, Specimen
from bilayer.validation import LARGEST, finite, fraction, keep, one_of, positive, whole, within
from fenics_model.plain_options import not_plain_option

BYTES_PER_TRIANGLE = 300_000
"""Memory of the matrix and its factors, one element through each of two layers (measured: 225 kB
per triangle at 2000 triangles; the factors grow a little faster than the mesh)."""
MOST_ELEMENTS, MOST_STEPS = 100, 100_000
HIGHEST_DEGREE = 20
"""Of the quadrature: its points, and the time to compile the forms, grow with the third power."""
SMALLEST_STEP = 1e-7
"""Of the prestretch, beyond which a load path makes no way."""


@dataclass(frozen=True)
class SolidSettings:
    """Settings of the layered solid and of its load path.

    Raises
    ------
    InputError
        A value is out of its range.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.SolidSettings(branch="other").branch
    'other'
    """

    substrate_elements: int = setting(1, "elements through a layer named substrate")
    kirigami_elements: int = setting(1, "elements through a layer named kirigami")
    elements: int | None = setting(
        None,
        "elements through each other layer, 1 if not set; the layer whose middle is the reference "
        "surface takes an even number, one more if need be",
    )
    quadrature_degree: int = setting(4, "polynomial degree that the quadrature integrates")
    first_step: float = setting(0.001, "first load step, as a change of the prestretch [1]")
    smallest_step: float = setting(1e-4, "smallest load step; if it fails, the path ends [1]")
    largest_step: float = setting(0.05, "largest load step [1]")
    target_iterations: int = setting(
        8, "corrections that a load step should take; its size grows or shrinks toward this"
    )
    iteration_limit: int = setting(12, "new tangents after which a load step has failed")
    flow_steps: int = setting(
        100,
        "maximum number of pseudo-time steps of the gradient flow, which finds a stable "
        "equilibrium if load steps fail or a milestone is unstable; 0: no gradient flow",
    )
    branch: str = setting(
        "lowest",
        "after a loss of stability, follow the branch of lowest energy ('lowest'), the other one "
        "('other'), or stay on the unstable one ('unstable'); use it with --start flat, because "
        "the shapes of a start may lead straight to a stable branch",
    )
    tolerance: float = setting(1e-10, "residual at a milestone, relative to the flat state's [1]")
    path_tolerance: float = setting(
        1e-3, "residual at the load steps between milestones, relative to the flat state's [1]"
    )
    imperfection: float = setting(
        0.1,
        "saddle-shaped vertical load that breaks the symmetry, acceleration at the rim, "
        "gone at every milestone [m/s2]",
    )
    contact: str = setting(
        "none",
        "'barrier': the body does not pass through itself (frictionless contact; needs ipctk); "
        "'none': it may, and shapes that do are flagged",
    )
    contact_range: float = setting(
        0.1,
        "barrier: distance from which on nothing acts, as a fraction of the thickness of all "
        "layers; less if the flat mesh has smaller distances [1]",
    )
    petsc_options: str = setting(
        "",
        "further PETSc options, such as '-bilayer_mat_mumps_icntl_4 2'; their prefix is bilayer_",
        not_plain=not_plain_option,
    )

    def __post_init__(self) -> None:
        elements, iterations = (
            ("substrate_elements", "kirigami_elements"),
            ("target_iterations", "iteration_limit"),
        )
        keep(self, whole, *elements, table="solver.", at_least=1, at_most=MOST_ELEMENTS)
        keep(self, whole, *iterations, table="solver.", at_least=1, at_most=MOST_STEPS)
        keep(self, whole, "quadrature_degree", table="solver.", at_least=1, at_most=HIGHEST_DEGREE)
        if self.elements is not None:
            keep(self, whole, "elements", table="solver.", at_least=1, at_most=MOST_ELEMENTS)
        keep(self, whole, "flow_steps", table="solver.", at_least=0, at_most=MOST_STEPS)
        steps = ("first_step", "smallest_step", "largest_step")
        keep(self, within, *steps, table="solver.", low=SMALLEST_STEP, high=LARGEST)
        keep(self, fraction, "tolerance", "path_tolerance", table="solver.")
        keep(self, finite, "imperfection", table="solver.")
        keep(self, one_of, "contact", table="solver.", choices=CONTACT_CHOICES)
        keep(self, positive, "contact_range", table="solver.")
        keep(self, one_of, "branch", table="solver.", choices=BRANCH_CHOICES)
        for smaller, larger in (("smallest_step", "first_step"), ("first_step", "largest_step")):
            if getattr(self, smaller) > getattr(self, larger):
                raise InputError(
                    f"solver.{smaller} = {getattr(self, smaller)!r}: expected at most "
                    f"solver.{larger} = {getattr(self, larger)!r}"
                )

    def elements_through(self, layer: str) -> int:
        """Return the number of elements that are asked for through a layer, by its name."""
        named = {SUBSTRATE: self.substrate_elements, KIRIGAMI_LAYER: self.kirigami_elements}
        return named.get(layer, 1 if self.elements is None else self.elements)


def elements_through(name: str, specimen: Specimen, settings: SolidSettings) -> int:
    """Return the number of elements through a layer: as asked, or more for the reference surface.

    That surface is a level of the mesh. So a layer that has it in its middle takes an even number.
    """
    surface, elements = specimen.reference_surface, settings.elements_through(name)
    while surface.layer == name and not (surface.share * elements).is_integer():
        elements += 1
    return elements


def bytes_per_triangle(specimen: Specimen, settings: SolidSettings) -> float:
    """Return the memory that the model of a specimen takes for each triangle of its planar mesh."""
    elements = sum(elements_through(name, specimen, settings) for name in specimen.layer_names)
    return BYTES_PER_TRIANGLE * elements / 2


MODELS = {"solid": SolidSettings}
