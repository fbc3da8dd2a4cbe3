"""The memory that is available, on this machine and on those of several ranks."""

import psutil
import pytest

from bilayer.runtime.memory import available_memory

pytestmark = pytest.mark.mpi


def test_ranks_on_one_machine_have_that_machine_s_memory():
    comm = pytest.importorskip("mpi4py.MPI").COMM_WORLD
    of_one = psutil.virtual_memory().available
    assert available_memory(comm) == pytest.approx(of_one, rel=0.1)
    assert available_memory() == pytest.approx(of_one, rel=0.1)
    assert len(set(comm.allgather(available_memory(comm)))) == 1
