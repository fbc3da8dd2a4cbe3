"""Cases started by a neighbour: fewer iterations, the same states, or else the usual way."""

from dataclasses import replace

import numpy as np
import pytest

from bilayer import MeshSize, open_result, paper_specimen
from bilayer.results.starting import Neighbour
from bilayer.study.case import Case
from bilayer.study.compute import compute_case
from bilayer.study.folder import StudyFolder
from bilayer.study.neighbours import Neighbours
from dshell import HingeSettings, MorleySettings, PaperSettings

NAME = "kirigami.thickness"
COARSE = replace(paper_specimen(), mesh=MeshSize(0.008))


def case_of(thickness, settings=None, **values):
    specimen = COARSE.with_milestones([1.03, 1.06]).with_layer("kirigami", thickness=thickness)
    chosen = MorleySettings() if settings is None else settings
    return Case(specimen, "dshell", "morley", chosen, {NAME: thickness, **values})


def computed(cases, folder, neighbours):
    study = StudyFolder(folder)
    study.make()
    for case in cases:
        compute_case(case, study, neighbours=neighbours)
    return [open_result(study.result_file(case.identity)) for case in cases]


def energies(results):
    return np.array([one["energy"].sum("term").values for one in results])


def is_led(result):
    return result.attrs["start"].startswith("another result")


THICKNESSES = (1e-3, 1.05e-3, 1.1e-3, 1.15e-3)


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """Return the results of four cases, each from flat."""
    return computed(map_cases(), tmp_path_factory.mktemp("usual"), None)


def map_cases(**more):
    return [case_of(thickness, **more) for thickness in THICKNESSES]


def test_a_neighbour_leads_to_the_same_states_in_fewer_iterations(usual, tmp_path):
    found = computed(map_cases(), tmp_path, Neighbours(sample=1000))
    assert [is_led(one) for one in found] == [False, False, True, True]  # the second is a sample
    assert energies(found) == pytest.approx(energies(usual), rel=1e-9)
    for one, other in zip(found, usual, strict=True):
        assert one.position.values == pytest.approx(other.position.values, abs=1e-8)
        assert one.unstable_modes.values.tolist() == [0, 0]
    led, flat = found[3].iterations.values, usual[3].iterations.values
    assert (led < flat).all()
    assert led.sum() < 0.5 * flat.sum()


class Recorded:
    """Computes a case by itself, and keeps how it was asked to."""

    def __init__(self, results):
        self.results, self.asked = iter(results), []

    def __call__(self, *, mesh=None, start=None):
        assert start is None or isinstance(start, Neighbour)
        self.asked.append("usual" if start is None else "led")
        return next(self.results)


@pytest.fixture
def neighbours(usual):
    """Return neighbours that have been given one case, and a check that agreed."""
    neighbours = Neighbours(sample=1000)
    neighbours.solve(case_of(1e-3), Recorded(usual[:1]))
    asked = Recorded([usual[1], usual[1]])
    neighbours.solve(case_of(1.05e-3), asked)
    assert asked.asked == ["led", "usual"]
    return neighbours


def with_energy(result, factor):
    return result.assign(energy=result["energy"] * factor)


def unstable(result):
    return result.assign(unstable_modes=result["unstable_modes"] + 1)


def slow(result):
    return result.assign(iterations=result["iterations"] + 50)


def missed(result):
    return result.assign(converged=0 * result["converged"])


def quick(result):
    return result.assign(iterations=0 * result["iterations"] + 2)


@pytest.mark.parametrize("doubt", [unstable, slow, missed])
def test_a_doubt_is_settled_in_the_usual_way(neighbours, usual, doubt):
    asked = Recorded([doubt(quick(usual[2])), usual[2]])
    assert neighbours.solve(case_of(1.1e-3), asked) is usual[2]
    assert asked.asked == ["led", "usual"]


def test_another_state_takes_back_what_was_not_checked(neighbours, usual):
    led = Recorded([quick(usual[2])])
    neighbours.solve(case_of(1.1e-3), led)
    assert led.asked == ["led"]
    assert neighbours.withdrawn() == []
    asked = Recorded([slow(with_energy(usual[3], 1 + 1e-8)), usual[3]])
    assert neighbours.solve(case_of(1.15e-3), asked) is usual[3]
    assert [case.values[NAME] for case in neighbours.withdrawn()] == [1.1e-3]
    assert neighbours.withdrawn() == []
    after = Recorded([usual[0]])
    neighbours.solve(case_of(1.2e-3), after)
    assert after.asked == ["usual"]


@pytest.mark.parametrize(
    "other",
    [
        case_of(2e-3),
        case_of(1.1e-3, **{"cut.strips": 5}),
        case_of(1.1e-3, settings=MorleySettings(tolerance=1e-7)),
        case_of(1.1e-3, settings=MorleySettings(branch="unstable")),
        case_of(1.1e-3, settings=HingeSettings(method="dynamic")),
        case_of(1.1e-3, settings=PaperSettings()),
        replace(case_of(1.1e-3), specimen=COARSE.with_milestones([1.03])),
        replace(case_of(1.1e-3), specimen=replace(case_of(1.1e-3).specimen, mesh=MeshSize(0.009))),
    ],
    ids=["far", "other field", "settings", "branch", "dynamic", "paper", "milestones", "mesh"],
)
def test_what_is_no_neighbour_starts_flat(neighbours, usual, other):
    asked = Recorded([usual[0]])
    neighbours.solve(other, asked)
    assert asked.asked == ["usual"]


def test_a_case_taken_back_is_computed_again(usual, tmp_path):
    """The study believes a wrong energy until the sample; then it has the usual result."""

    class Misled(Neighbours):
        def solve(self, case, solve):
            def misled(*, mesh=None, start=None):
                result = solve(mesh=mesh, start=start)
                return result if start is None else with_energy(result, 1.001)

            return super().solve(case, misled)

    neighbours = Misled(sample=3)
    neighbours._started = 1  # the second case started is no sample, the third one is
    found = computed(map_cases(), tmp_path, neighbours)
    assert [is_led(one) for one in found] == [False] * 4
    assert energies(found) == pytest.approx(energies(usual), rel=1e-9)
