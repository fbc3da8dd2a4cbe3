"""A study without contact and the one with it, as one."""

import xarray as xr

from bilayer.results.caveats import touches_itself

WITHOUT = "quality_without_contact"
"""Of a point that contact has moved: its quality without."""


def with_contact(plain: xr.Dataset, pressing: xr.Dataset | None = None) -> xr.Dataset:
    """Return a study in which points with contact take the place of those that touch without it.

    Parameters
    ----------
    plain : Dataset
        The study without contact.
    pressing : Dataset, optional
        With contact, of some of the cases and others, up to some of the prestretches. Only points
        that were reached count, and only if the one without contact touches itself or is missing.
    """
    if pressing is None or "converged" not in pressing:  # none of it is computed
        return plain
    wanting = plain["converged"].copy(data=touches_itself(plain)) | (plain["converged"] != 1)
    is_due = wanting.reindex_like(pressing["converged"], fill_value=True)
    names = [name for name in plain.coords if name not in plain.dims and name in pressing]
    labels = (study[names].reset_coords() for study in (plain, pressing))
    taken = pressing.where(is_due & (pressing["converged"] == 1)).drop_vars(names)
    without = plain["quality"].drop_vars(names).reindex_like(taken["quality"])
    taken[WITHOUT] = without.where(taken["converged"] == 1)
    one, other = (
        first.combine_first(second) for first, second in ((taken, plain.drop_vars(names)), labels)
    )
    return one.merge(other).set_coords(names)
