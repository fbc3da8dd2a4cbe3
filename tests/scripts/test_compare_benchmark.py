"""Two revisions side by side: what is run, what is kept, what is refused."""

import json
import subprocess

import pytest
import run_benchmark
from benchmarks import compare
from benchmarks.compare import CHECKOUT, Comparison

from bilayer.errors import ComputationError


def comparison(case="shell", revision="b", cpu=(1.0, 3.0), numbers=(2.0, 4.0)):
    now = [cost(seconds, numbers) for seconds in cpu]
    return Comparison(case, revision, "a", now, [cost(2.0, (2.0, 5.0)) for _ in cpu])


def cost(seconds, numbers):
    return {
        "cpu": seconds,
        "gigabytes": 0.5,
        "iterations": 7,
        "factorisations": None,
        "numbers": list(numbers),
    }


def test_ratios_are_of_one_turn_and_the_difference_is_relative():
    one = comparison()
    assert one.ratios("cpu") == [0.5, 1.5]
    assert one.largest_difference() == pytest.approx(0.2)
    assert comparison(numbers=(2.0, 5.0)).largest_difference() == 0.0
    text = compare.table([one])
    assert "1.00 (0.50, 1.50)" in text
    assert "7→7" in text
    assert "2e-01" in text


def test_results_of_other_milestones_are_no_comparison():
    with pytest.raises(ComputationError, match="of 2 and 1 numbers"):
        comparison(numbers=(2.0,)).largest_difference()


def test_a_machine_keeps_one_comparison_of_each_case(tmp_path):
    compare.keep([comparison("study"), comparison("shell", revision="b")], tmp_path)
    found = compare.keep([comparison("shell", revision="c")], tmp_path)
    assert [(one.case, one.revision) for one in found] == [("shell", "c"), ("study", "b")]
    (file,) = tmp_path.glob("*.json")
    document = json.loads(file.read_text())
    assert document["machine"]["cores"] >= 1
    assert [one["case"] for one in document["comparisons"]] == ["shell", "study"]
    assert compare.table(found) == compare.table(compare.keep([], tmp_path))


def test_two_revisions_run_and_leave_nothing_behind(capsys):
    before = worktrees()
    assert run_benchmark.main(["compare", "HEAD", "import", "--turns", "1"]) == 0
    assert "import bilayer" in capsys.readouterr().out
    assert worktrees() == before


def test_each_revision_runs_its_own_code(tmp_path):
    (tmp_path / "bilayer").mkdir()
    (tmp_path / "bilayer" / "__init__.py").write_text("raise ImportError('the earlier one')\n")
    with pytest.raises(subprocess.CalledProcessError):
        compare.revision_of(tmp_path)
    subprocess.run(["git", "init", "--quiet", tmp_path], check=True)
    identity = ["-c", "user.name=n", "-c", "user.email=e"]
    subprocess.run(
        ["git", "-C", tmp_path, *identity, "commit", "-q", "--allow-empty", "-m", "c"], check=True
    )
    with pytest.raises(ComputationError, match="the earlier one"):
        compare.cost_of("import", tmp_path)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["no-such-revision"], "REV = no-such-revision: expected a commit"),
        (["HEAD", "nothing"], "CASE nothing: expected one of shell"),
        (["HEAD", "import", "--turns", "0"], "--turns = 0: expected at least 1"),
    ],
)
def test_a_wrong_word_is_refused(words, said, capsys):
    assert run_benchmark.main(["compare", *words]) == 2
    assert said in capsys.readouterr().err


def worktrees():
    command = ["git", "-C", str(CHECKOUT), "worktree", "list", "--porcelain"]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [line for line in listed.splitlines() if "bilayer-earlier-" in line]


def kept(folder, name, cpu, numbers=(2.0, 4.0)):
    one = vars(comparison(cpu=(cpu, cpu), numbers=numbers))
    path = folder / name
    path.write_text(json.dumps({"machine": {"cores": cpu}, "comparisons": [one]}), encoding="utf-8")
    return str(path)


def test_the_files_of_two_machines_are_compared(tmp_path, capsys):
    first, second = kept(tmp_path, "a.json", 2.0), kept(tmp_path, "b.json", 3.0, (2.0, 4.04))
    assert run_benchmark.main(["machines", first, second]) == 0
    text = capsys.readouterr().out
    assert "2.0  |  3.0" in text
    assert "2.00 3.00  1.50" in text
    assert "1e-02" in text


def test_what_is_no_file_of_a_machine_is_refused(tmp_path, capsys):
    first, other = kept(tmp_path, "a.json", 2.0), tmp_path / "b.json"
    other.write_text('{"machine": {}, "comparisons": []}', encoding="utf-8")
    assert run_benchmark.main(["machines", first, str(other)]) == 2
    assert "no case in common" in capsys.readouterr().err
    other.write_text("[]", encoding="utf-8")
    assert run_benchmark.main(["machines", first, str(other)]) == 2
    assert "expected the keys machine and comparisons" in capsys.readouterr().err
