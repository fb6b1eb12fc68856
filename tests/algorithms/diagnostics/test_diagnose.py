"""A diagnosis of a run has every number, the same each time."""

import math

import pytest

import algorithms
from algorithms.snapshot import Snapshot


@pytest.fixture(scope="module")
def snapshot() -> Snapshot:
    learner = algorithms.build("ddpg", "Pendulum", [0], timesteps=200)
    while not learner.finished:
        learner.advance()
    learned = learner.snapshot(0)
    assert learned is not None
    return learned


@pytest.fixture(scope="module")
def findings(snapshot: Snapshot) -> list[algorithms.Finding]:
    return algorithms.diagnose("Pendulum", snapshot, gamma=0.99)


def test_every_diagnostic_is_there_once(findings: list[algorithms.Finding]) -> None:
    names = [finding[:-1] for finding in findings]
    assert len(set(names)) == len(names)
    count = {name: sum(each[0] == name for each in names) for name, *_ in names}
    assert count == {
        "smoothing": 2 * 6 * 5, "growth": 6 * 2, "kinks": 1 + 3, "target": 4, "critic": 5 * 4,
        "loss": 2,
    }  # fmt: skip


def test_numbers_are_in_their_range(findings: list[algorithms.Finding]) -> None:
    assert all(math.isfinite(each.value) for each in findings)
    for each in findings:
        if each.quantity.endswith("cosine"):
            assert abs(each.value) <= 1 + 1e-12
        elif each.diagnostic in {"smoothing", "growth"}:
            assert each.value >= 0
        else:
            assert 0 <= each.value <= 1
    regimes = [each.value for each in findings if each.quantity.startswith("in ")]
    assert sum(regimes) == pytest.approx(1.0)


def test_the_seed_decides_every_number(
    snapshot: Snapshot, findings: list[algorithms.Finding]
) -> None:
    assert algorithms.diagnose("Pendulum", snapshot, gamma=0.99) == findings
    others = algorithms.diagnose("Pendulum", snapshot, gamma=0.99, seed=1)
    assert [each[:-1] for each in others] == [each[:-1] for each in findings]
    assert others != findings


def test_without_a_critic_or_a_discount_there_are_none_about_critics(snapshot: Snapshot) -> None:
    found = algorithms.diagnose("Pendulum", snapshot._replace(critic=None), gamma=0.99)
    assert {each.diagnostic for each in found} == {"smoothing", "growth", "kinks"}
    assert algorithms.diagnose("Pendulum", snapshot) == found
