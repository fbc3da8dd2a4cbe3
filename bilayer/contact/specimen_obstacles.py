"""The obstacles of a specimen as a barrier of its skin."""

from bilayer.contact.barrier import Barrier
from bilayer.contact.obstacles import Obstacle, ObstacleBarrier, Plane, Sphere, resting_share
from bilayer.contact.package import require_contact
from bilayer.contact.several import SeveralBarriers, SkinBarrier
from bilayer.errors import InputError
from bilayer.geometry.surface import Surface
from bilayer.specimen.obstacle import UP, PlaneObstacle
from bilayer.specimen.obstacle import Obstacle as ObstacleInFile
from bilayer.specimen.specimen import Specimen


def check_obstacles_are_seen(specimen: Specimen, contact: str) -> None:
    """Raise unless contact is modelled, by a setting and an installed package, if it has to be.

    Raises
    ------
    InputError
        The setting is another.
    ComputationError
        The package is missing.
    """
    if not specimen.obstacles:
        return
    if contact != "barrier":
        name = specimen.obstacles[0].name
        raise InputError(
            f"solver.contact = {contact!r}: expected 'barrier', for [obstacles.{name}] "
            "(--set solver.contact=barrier)"
        )
    require_contact()


def with_obstacles(itself: Barrier, specimen: Specimen, flat: Surface) -> SkinBarrier:
    """Return the barrier of a skin against itself and the obstacles of its specimen.

    Parameters
    ----------
    itself : Barrier
        Against itself.
    specimen : Specimen
        Whose obstacles.
    flat : Surface
        The flat skin.

    Raises
    ------
    InputError
        An obstacle reaches into the flat sheet.
    """
    if not specimen.obstacles:
        return itself
    bodies = [_body(each, specimen, itself, flat) for each in specimen.obstacles]
    for each, body in zip(specimen.obstacles, bodies, strict=True):
        least = float(body.distance(flat.points).min())
        if least <= 0:
            raise InputError(
                f"obstacles.{each.name}: reaches {-1e3 * least:.3g} mm into the flat sheet, "
                "expected outside of it"
            )
    others = ObstacleBarrier(
        bodies, flat.node_areas, range=itself.range, stiffness=itself.stiffness
    )
    return SeveralBarriers([itself, others])


def _body(each: ObstacleInFile, specimen: Specimen, barrier: Barrier, flat: Surface) -> Obstacle:
    if not isinstance(each, PlaneObstacle):
        return Sphere(each.centre, each.radius)
    if each.point is not None:
        return Plane(each.point, each.normal)
    lying = resting_share(_weight_per_area(specimen) / barrier.stiffness) * barrier.range
    return Plane((0.0, 0.0, float(flat.points[:, 2].min()) - lying), UP)


def _weight_per_area(specimen: Specimen) -> float:
    """Return the weight of the sheet where all layers lie, Pa."""
    return specimen.gravity * sum(layer.density * layer.thickness for layer in specimen.layers)
