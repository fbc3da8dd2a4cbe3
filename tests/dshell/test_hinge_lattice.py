"""Natural angles of a lattice of hinges; its energies are rung 9 of the ladder."""

import numpy as np
import pytest
from verification.hinge_lattice import dihedral_of_a_sphere


def test_natural_dihedral_of_a_sphere():
    assert dihedral_of_a_sphere() == pytest.approx(1 / np.sqrt(3), rel=3e-3)
