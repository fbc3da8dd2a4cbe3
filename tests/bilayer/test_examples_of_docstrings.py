"""The examples in the docstrings of public names say the truth."""

import doctest

import pytest

import bilayer

NAMES = [name for name in bilayer.__all__ if callable(getattr(bilayer, name))]
SKIPPED = {
    "fit_to_scan": "the file of a scan",
    "open_study": "a folder that a study has filled",
    "run_study": "processes of its own, which import the script that starts them",
}
"""Those whose example is shown and not run, and what it needs."""


def example_of(name):
    finder = doctest.DocTestFinder(recurse=False)
    (found,) = finder.find(getattr(bilayer, name), f"bilayer.{name}")
    return found


def test_only_few_examples_are_skipped():
    assert {name for name in NAMES if is_skipped(name)} == set(SKIPPED)


def is_skipped(name):
    return any(doctest.SKIP in line.options for line in example_of(name).examples)


@pytest.mark.parametrize("name", [name for name in NAMES if name not in SKIPPED])
def test_its_example_is_right(name):
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    said = []
    runner.run(example_of(name), out=said.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(said)
