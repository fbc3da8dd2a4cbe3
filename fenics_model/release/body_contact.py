"""The contact of a specimen's solid, if it is to be modelled and can be."""

from bilayer.contact.barrier import Barrier
from bilayer.contact.limits import barrier_range, barrier_stiffness
from bilayer.contact.package import contact_is_installed
from bilayer.contact.specimen_obstacles import check_obstacles_are_seen, with_obstacles
from bilayer.geometry.surface import Surface
from fenics_model.contact.solid_skin import SolidSkin
from fenics_model.contact.surface_contact import SurfaceContact
from fenics_model.release.specimen_solid import SpecimenSolid


def make_contact(body: SpecimenSolid) -> SurfaceContact | None:
    """Return the contact of a body with itself; None if the settings have none, or ipctk lacks."""
    settings, specimen = body.settings, body.specimen
    check_obstacles_are_seen(specimen, settings.contact)
    if settings.contact == "none" or not contact_is_installed():
        return None
    skin = SolidSkin.of(body.solid.mesh.volume, body.mesh)
    barrier = Barrier(
        skin.triangles,
        skin.flat,
        skin.fibre,
        skin.neighbours,
        range=barrier_range(specimen, settings.contact_range),
        stiffness=barrier_stiffness(specimen),
    )
    whole = with_obstacles(barrier, specimen, Surface(skin.flat, skin.triangles))
    return SurfaceContact(body.solid, skin, whole)
