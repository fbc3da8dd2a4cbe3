"""The shell's benchmark: what it counts, where it sends time, what it refuses."""

import time

import pytest
import run_benchmark
from benchmarks.page import with_part
from benchmarks.sections import cpu_by_section
from benchmarks.shell_release import BenchmarkCase, measure_cost

from bilayer import InputError


class Work:
    def outer(self):
        begin = time.process_time()
        while time.process_time() < begin + 0.02:
            pass
        return self.inner()

    def inner(self):
        return "done"


def test_a_section_has_the_time_of_what_it_calls():
    original = Work.outer
    with cpu_by_section({"all": [(Work, "outer")], "part": [(Work, "inner")]}) as seconds:
        assert Work().outer() == "done"
    assert seconds["all"] >= 0.02
    assert seconds["part"] == 0.0
    assert Work.outer is original


def test_a_release_reaches_its_target_in_one_step():
    found = measure_cost(BenchmarkCase(400, 1.15))
    assert found["converged"]
    assert found["load steps"] == 1
    assert 5 < found["iterations"] <= 14  # 21 if the factor does not learn
    assert found["triangles"] == pytest.approx(400, rel=0.5)
    sections = ("set-up", "assembly", "factorisation", "solution", "measures", "rest")
    assert sum(found[name] for name in sections) == pytest.approx(found["total"])
    assert found["assembly"] > 0
    assert found["start-up"] > 0
    assert found["factorisation"] > 0


def test_a_page_keeps_what_is_not_the_benchmarks_own():
    begin, end = (f"<!-- {edge} of scripts/benchmark a -->" for edge in ("begin", "end"))
    page = f"before\n{begin}\nold\n{end}\nafter"
    new = with_part(page, "a", ["one", "two"])
    assert new.startswith("before\n")
    assert new.endswith("\nafter")
    assert "old" not in new
    assert new.index("one") < new.index("two")
    assert with_part(new, "a", ["one", "two"]) == new
    with pytest.raises(InputError, match="benchmark b"):
        with_part(page, "b", [])


def test_a_peer_that_is_not_there_is_refused(tmp_path, capsys):
    assert run_benchmark.main(["dshell", "--peer", str(tmp_path)]) == 2
    assert "expected a checkout of dismech-python" in capsys.readouterr().err
