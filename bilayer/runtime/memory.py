"""The memory that is available to a computation, on one machine or on those of its ranks."""

import math
import re
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from bilayer.runtime.system import address_space_left

CONTROL_GROUPS, OWN_GROUP = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")


def ranks_of_this_machine(comm: Any) -> Any:
    """Return the communicator of the ranks that share this rank's memory."""
    from mpi4py import MPI

    return comm.Split_type(MPI.COMM_TYPE_SHARED)


def _of_this_process() -> int:
    """Return the memory that the machine has and that the limits of this process leave, bytes."""
    import psutil

    machine = int(psutil.virtual_memory().available)
    address_space = address_space_left(psutil.Process().memory_info().vms)
    return int(max(min(machine, address_space, control_group_left(CONTROL_GROUPS)), 0))


def control_group_left(root: Path) -> float:
    """Return the memory that the control group of this process has left, bytes; inf if no limit.

    Source: Linux, Documentation/admin-guide/cgroup-v2.rst, "Memory Interface Files". Batch systems
    and containers limit by it.

    Parameters
    ----------
    root : Path
        Where the control groups are mounted.
    """
    with suppress(OSError, ValueError):
        own = OWN_GROUP.read_text(encoding="utf-8").partition("0::/")[2]
        group = root / own.partition("\n")[0]
        groups = [folder for folder in (group, *group.parents) if folder.is_relative_to(root)]
        return min(map(_left_in, groups))
    return math.inf


def _left_in(group: Path) -> float:
    def content(name: str) -> str:
        return (group / f"memory.{name}").read_text(encoding="utf-8")

    with suppress(OSError, ValueError):
        cached = re.search(r"^inactive_file (\d+)$", content("stat"), re.MULTILINE)
        left = int(content("max")) - int(content("current"))
        return left + (int(cached[1]) if cached else 0)
    return math.inf


def available_memory(
    comm: Any = None, machine_of: Callable[[Any], Any] = ranks_of_this_machine
) -> int:
    """Return the memory that is available, bytes.

    Parameters
    ----------
    comm : mpi4py.MPI.Comm, optional
        The ranks that share a model, possibly on several machines: each machine counts once. All
        of them call. This machine alone if left out.
    machine_of : callable
        Returns the communicator of the ranks on the same machine.
    """
    here = _of_this_process()
    if comm is None or comm.Get_size() == 1:
        return here
    machine = machine_of(comm)
    speaks_for_it = machine.Get_rank() == 0
    machine.Free()
    return int(comm.allreduce(here if speaks_for_it else 0))
