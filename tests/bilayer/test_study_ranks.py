"""Studies on the ranks of mpirun: one queue, nothing done twice, errors that all ranks see."""

import pytest
from studies_for_tests import QUICK, log_lines, write_study

from bilayer.errors import ComputationError, InputError
from bilayer.study.folder import StudyFolder
from bilayer.study.plan import read_study
from bilayer.study.run import run_study_on_ranks

pytestmark = pytest.mark.mpi


@pytest.fixture
def world():
    return pytest.importorskip("mpi4py.MPI").COMM_WORLD


@pytest.fixture
def shared_folder(world, tmp_path):
    """The first rank's folder, on every rank."""
    yield world.bcast(tmp_path)
    world.Barrier()


def study_of(world, folder, text):
    if world.Get_rank() == 0:
        write_study(folder, text)
    world.Barrier()
    return read_study(folder / "study.toml")


@pytest.mark.parametrize("ranks_per_case", [1, "all"])
def test_groups_of_ranks_share_one_queue(world, shared_folder, ranks_per_case):
    plan = study_of(
        world, shared_folder, QUICK + '[vary]\n"cut.cutout_angle" = [0.2, 0.3, 0.4, 0.5]\n'
    )
    size = world.Get_size() if ranks_per_case == "all" else 1
    index = run_study_on_ranks(plan, shared_folder / "out", world, ranks_per_case=size)
    assert list(index["status"]) == ["done"] * 8
    world.Barrier()
    done = log_lines(shared_folder / "out", "done")
    assert sorted(done) == sorted(case.identity for case in plan.cases)
    world.Barrier()
    run_study_on_ranks(plan, shared_folder / "out", world, ranks_per_case=size)
    assert len(log_lines(shared_folder / "out", "begun")) == 4


def test_all_ranks_see_the_error_of_the_first(world, shared_folder):
    plan = study_of(world, shared_folder, QUICK)
    folder = StudyFolder(shared_folder / "out")
    if world.Get_rank() == 0:
        folder.make()
        held = folder.lock_for_study()
        held.__enter__()
    world.Barrier()
    with pytest.raises(ComputationError, match="another study is running"):
        run_study_on_ranks(plan, shared_folder / "out", world)
    if world.Get_rank() == 0:
        held.__exit__(None, None, None)


def test_more_ranks_for_a_case_than_there_are_is_refused(world, shared_folder):
    plan = study_of(world, shared_folder, QUICK)
    with pytest.raises(InputError, match="--ranks-per-case = 99"):
        run_study_on_ranks(plan, shared_folder / "out", world, ranks_per_case=99)
