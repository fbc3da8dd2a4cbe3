"""The verb `study`: many specimens from one file; finished cases are kept and not repeated."""

import argparse
import os
from typing import Any

import pandas as pd

from bilayer.cli.parser import add_trust_argument, add_verb
from bilayer.errors import InputError
from bilayer.runtime.memory import available_memory
from bilayer.runtime.progress import progress_bar
from bilayer.runtime.ranks import is_first_rank, join_mpi, world_of_ranks
from bilayer.runtime.system import available_cores
from bilayer.runtime.terminal import one_line, say, tell
from bilayer.runtime.time_limit import read_duration
from bilayer.study.case_table import case_table
from bilayer.study.estimate import estimate, estimate_text
from bilayer.study.folder import StudyFolder
from bilayer.study.index import read_index
from bilayer.study.memory import first_at_once, separate_by_memory
from bilayer.study.plan import StudyPlan, read_study
from bilayer.study.records import CASE_DONE, CASE_LACKS_MEMORY
from bilayer.study.run import (
    LONGEST,
    ORDERS,
    cases_to_compute,
    run_one_case,
    run_study,
    run_study_on_ranks,
)
from bilayer.validation import whole


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "study",
        "bilayer study study.toml -o study --dry-run\n"
        "  bilayer study study.toml -o study --jobs 4\n"
        "  mpirun -n 8 bilayer study study.toml -o study --ranks-per-case 2",
    )  # fmt: skip
    verb.add_argument("study", help="the study's TOML file")
    verb.add_argument("-o", "--output", required=True, metavar="DIR", help="the study's folder")
    verb.add_argument(
        "--jobs",
        metavar="N",
        help="most cases at a time, as far as the memory goes; default: one a core",
    )
    verb.add_argument(
        "--ranks-per-case", default="1", metavar="N", help="under mpirun: ranks that share a case"
    )
    verb.add_argument(
        "--retry-failed", action="store_true", help="compute again what failed or stopped early"
    )
    verb.add_argument(
        "--first", choices=list(ORDERS), default=LONGEST,
        help="which cases begin: 'longest', so that all cores end together (the default); "
        "'cheapest', to have something to look at soon",
    )  # fmt: skip
    verb.add_argument(
        "--limit", metavar="TIME",
        help="most time for a milestone, such as 90s, 5min or 2h; a case stops early at one that "
        "takes longer, --retry-failed goes on there",
    )  # fmt: skip
    add_trust_argument(verb)
    what = verb.add_mutually_exclusive_group()
    what.add_argument(
        "--dry-run", action="store_true", help="print cases, memory and time; compute nothing"
    )
    what.add_argument(
        "--case", metavar="I", help="compute only the case of this number, from 1; for job arrays"
    )


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    join_mpi()
    plan = read_study(options.study, trust=options.trust, notice=_notice)
    jobs = available_cores() if options.jobs is None else _count("--jobs", options.jobs)
    ranks_per_case = _count("--ranks-per-case", options.ranks_per_case)
    world = world_of_ranks()
    if options.dry_run:
        memory = available_memory(world)
        if is_first_rank():
            at_a_time = jobs if world is None else -(-world.Get_size() // ranks_per_case)
            say(_expectation(plan, options, at_a_time, memory))
        return 0
    if options.case is not None:
        return _run_case(plan, options, world)
    limit = _limit(options)
    _one_thread_per_process()
    with progress_bar("study", shown=is_first_rank() and not options.quiet) as progress:
        if world is None:
            index = run_study(
                plan, options.output, jobs=jobs, retry_failed=options.retry_failed,
                first=options.first, limit=limit, progress=progress, notice=_notice,
            )  # fmt: skip
        else:
            index = run_study_on_ranks(
                plan, options.output, world, ranks_per_case=ranks_per_case,
                retry_failed=options.retry_failed, first=options.first, limit=limit,
                progress=progress, notice=_notice,
            )  # fmt: skip
    return _report(index, options) if is_first_rank() else _status(index)


def _run_case(plan: StudyPlan, options: argparse.Namespace, world: Any) -> int:
    number = _count("--case", options.case)
    run_one_case(
        plan, options.output, number, world=world, retry_failed=options.retry_failed,
        limit=_limit(options), notice=_notice,
    )  # fmt: skip
    identity = plan.cases[number - 1].identity
    index = read_index(StudyFolder(options.output))
    return _report(index[index["case"] == identity], options) if is_first_rank() else 0


def _limit(options: argparse.Namespace) -> float | None:
    return None if options.limit is None else read_duration("--limit", options.limit)


def _notice(line: str) -> None:
    tell(f"bilayer: {line}")


def _expectation(plan: StudyPlan, options: argparse.Namespace, jobs: int, memory: float) -> str:
    """Return the number of cases by status, in one line, and a line for each without memory."""
    folder = StudyFolder(options.output)
    index = _index_so_far(folder)
    waiting = cases_to_compute(plan, folder, options.retry_failed)
    fitting, shortages = separate_by_memory(waiting, memory)
    at_a_time = first_at_once(fitting, jobs, memory)
    lines = [
        f"{len(plan.cases)} cases, {estimate_text(estimate(fitting, index), at_a_time)}",
        *(
            one_line(f"case {case.identity} ({case}) {CASE_LACKS_MEMORY}: {why}")
            for case, why in shortages.items()
        ),
    ]
    return "\n".join(lines)


def _index_so_far(folder: StudyFolder) -> pd.DataFrame | None:
    """Return the index of earlier starts; None if there was none, or its plan is damaged."""
    try:
        return read_index(folder)
    except InputError:
        return None


def _report(index: pd.DataFrame, options: argparse.Namespace) -> int:
    """Print what there is now; return the exit status."""
    cases = index.drop_duplicates("case")
    bad = cases[cases["status"] != CASE_DONE]
    for _, case in bad.iterrows():
        tell(f"bilayer: case {case['case']} ({_values(case)}) {case['status']}: {case['reason']}")
    if not options.quiet:
        say(case_table(index))
        counts = cases["status"].value_counts()
        say(", ".join(f"{count} {status}" for status, count in counts.items()))
        say(one_line(StudyFolder(options.output).index_file))
    return _status(index)


def _status(index: pd.DataFrame) -> int:
    return int(bool((index["status"] != CASE_DONE).any()))


def _values(case: pd.Series) -> str:
    columns = list(case.index)
    names = columns[columns.index("model") + 1 : columns.index("prestretch")]
    varied = case[names].dropna()
    return ", ".join([case["solver"], *(f"{name} = {value}" for name, value in varied.items())])


def _count(name: str, word: str) -> int:
    try:
        return whole(name, float(word), at_least=1)
    except ValueError:
        raise InputError(f"{name} = {word}: expected a whole number of at least 1") from None


def _one_thread_per_process() -> None:
    """Let BLAS use one thread in each process, unless the user asks for more."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
