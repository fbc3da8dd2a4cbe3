"""The memory that is available, on this machine and on those of several ranks."""

import psutil
import pytest

from bilayer.runtime.memory import available_memory

pytestmark = pytest.mark.mpi


@pytest.fixture
def world():
    return pytest.importorskip("mpi4py.MPI").COMM_WORLD


def test_ranks_on_one_machine_have_that_machine_s_memory(world):
    of_one = psutil.virtual_memory().available
    assert available_memory() == pytest.approx(of_one, rel=0.1)
    assert available_memory(world) == pytest.approx(of_one, rel=0.1)
    assert len(set(world.allgather(available_memory(world)))) == 1


def test_machines_add_up(world):
    """As if every rank were on a machine of its own."""
    of_one = psutil.virtual_memory().available
    found = available_memory(world, machine_of=lambda comm: comm.Split(comm.Get_rank()))
    assert found == pytest.approx(world.Get_size() * of_one, rel=0.1)
