"""Work of the first rank alone, whose errors reach every rank."""

import pytest

from bilayer.errors import ComputationError, InputError
from bilayer.runtime.ranks import on_first_rank


@pytest.fixture
def world():
    return pytest.importorskip("mpi4py.MPI").COMM_WORLD


@pytest.mark.mpi
def test_the_first_rank_works_and_the_others_wait(world):
    done = []
    on_first_rank(world, lambda: done.append(world.rank))
    assert done == ([0] if world.rank == 0 else [])


@pytest.mark.mpi
@pytest.mark.parametrize("error", [InputError("a value"), LookupError("a fault")])
def test_an_error_of_the_first_rank_reaches_all(world, error):
    def fail():
        raise error

    is_own = isinstance(error, InputError) or world.rank == 0
    with pytest.raises(type(error) if is_own else ComputationError, match=str(error.args[0])):
        on_first_rank(world, fail)


def test_a_process_alone_works_itself():
    done = []
    on_first_rank(None, lambda: done.append(1))
    assert done == [1]
