"""Successive halving as a pure function of what runs have measured."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.analysis.halving import Ladder, ladders, wanted
from service.model.inquiry.search import Search, SearchScore, rungs_of, search_seeds
from service.model.request.entry import Entries
from service.model.run import RunStatus
from service.model.run_curve import RunCurve
from tests.service.scored import run_curve
from workers.messages.random_return import RandomReturn

NOISES = [0.1, 0.2, 0.3, 0.4]
STEPS = 2400
ENTRIES = Entries(
    {
        "algorithms": [{"name": "ddpg", "config": {"noise": NOISES}}],
        "environments": ["Pendulum"],
        "seeds": 2,
    }
)
LABELS = [entry.label for entry in ENTRIES.all]
ZEROS = {("Pendulum", 1): RandomReturn("Pendulum", 1, -100.0, -101.0, -99.0, 1000)}


def search(score: SearchScore = "final", seeds: int = 2) -> Search:
    """Four entries to 800 timesteps, the best two of them to 2400."""
    return Search(10**6, 3, score, search_seeds(seeds), {"Pendulum": rungs_of(4, STEPS, 3)})


def run(entry: int, values: Sequence[float], seed: int = 0, **fields: Any) -> RunCurve:
    """A run whose normalised returns at 800, 1600, ... are these, and which reached its end."""
    fields = {"timesteps": 800 * len(values), "entry": entry, **fields}
    return run_curve("ddpg", "Pendulum", seed, [100 * value - 100 for value in values], **fields)


def climbed(runs: Sequence[RunCurve], **fields: Any) -> Ladder:
    [ladder] = ladders(runs, ENTRIES, search(**fields), ZEROS, lambda _: 0.0)
    return ladder


def pairs(*scores: float) -> list[RunCurve]:
    """Two runs of each entry on the first rung, around its score."""
    return [
        run(entry, [score + off], seed)
        for entry, score in enumerate(scores)
        for seed, off in enumerate((-0.05, 0.05))
    ]


def longer(runs: Sequence[RunCurve], entry: int, *values: float) -> list[RunCurve]:
    """The runs, of which those of an entry went on."""
    return [
        run(entry, [(each.values[0] + 100) / 100, *values], each.spec.seed)
        if each.entry == entry
        else each
        for each in runs
    ]


def test_the_best_go_on_and_then_the_best_is_found() -> None:
    runs = pairs(0.5, 0.7, 0.2, 0.6)
    ladder = climbed(runs)
    assert [each.label for each in ladder.climbs[0].standings] == [
        LABELS[1], LABELS[3], LABELS[0], LABELS[2],
    ]  # fmt: skip
    assert ladder.climbs[0].standings[0].score == pytest.approx(0.7)
    assert wanted([ladder]) == {("Pendulum", LABELS[i]): STEPS for i in (1, 3)}
    assert ladder.winner is None
    ladder = climbed(longer(longer(runs, 1, 0.7, 0.7), 3, 0.7, 0.9))
    assert wanted([ladder]) == {}
    assert ladder.winner is not None
    assert ladder.winner.label == LABELS[3]
    assert ladder.winner.score == pytest.approx(0.9)


def test_a_rung_is_looked_at_when_all_its_runs_have_ended() -> None:
    runs = pairs(0.5, 0.7, 0.2, 0.6)
    on_the_way = run(2, [], 1, status=RunStatus.RUNNING, timesteps=800)
    ladder = climbed([*runs[:5], on_the_way, *runs[6:]])
    assert not ladder.climbs[0].is_over
    assert math.isnan(ladder.climbs[0].standings[2].score)
    assert wanted([ladder]) == dict.fromkeys([("Pendulum", label) for label in LABELS], 800)


def test_of_equals_the_first_goes_on() -> None:
    ladder = climbed(pairs(0.5, 0.5, 0.5, 0.5))
    assert [each.label for each in ladder.climbs[0].best] == LABELS[:2]


def test_a_divergence_counts_as_acting_at_random() -> None:
    runs = pairs(0.5, 0.7, -0.3, 0.6)
    runs[2] = run(1, [], 0, status=RunStatus.DIVERGED, timesteps=800)
    standings = {each.label: each for each in climbed(runs).climbs[0].standings}
    assert standings[LABELS[1]].score == pytest.approx(0.75 / 2)
    assert standings[LABELS[1]].diverged == 1


@pytest.mark.parametrize("status", [RunStatus.FAILED, RunStatus.CANCELLED])
def test_an_entry_with_a_run_that_says_nothing_is_left_out(status: RunStatus) -> None:
    runs = pairs(0.5, 0.7, 0.2, 0.6)
    runs[2] = run(1, [], 0, status=status, timesteps=800)
    ladder = climbed(runs)
    assert [each.label for each in ladder.climbs[0].best] == [LABELS[3], LABELS[0]]
    assert ladder.climbs[0].standings[-1].failed == 1
    none_left = climbed([run(i, [], s, status=status) for i in range(4) for s in (0, 1)])
    assert none_left.winner is None
    assert wanted([none_left]) == {}


def test_what_ends_badly_on_a_higher_rung_was_there_on_the_lower_one() -> None:
    runs = longer(pairs(0.5, 0.7, 0.2, 0.6), 3, 0.7, 0.9)
    runs = [
        run(1, [(each.values[0] + 100) / 100], each.spec.seed, status=RunStatus.FAILED,
            timesteps=STEPS) if each.entry == 1 else each
        for each in runs
    ]  # fmt: skip
    ladder = climbed(runs)
    assert [each.label for each in ladder.climbs[0].best] == [LABELS[1], LABELS[3]]
    assert ladder.winner is not None
    assert ladder.winner.label == LABELS[3]


def test_the_area_is_that_up_to_the_rung() -> None:
    runs = longer(longer(pairs(0.5, 0.7, 0.2, 0.6), 1, 0.9, 0.9), 3, 0.0, 1.0)
    ladder = climbed(runs, score="area")
    assert ladder.climbs[1].standings[0].score == pytest.approx((0.7 / 2 + 0.9 + 0.9 / 2) / 2)


@given(
    st.lists(st.floats(-1, 1), min_size=24, max_size=24),
    st.lists(st.sampled_from([None, *RunStatus]), min_size=8, max_size=8),
)
def test_no_rung_changes_with_what_is_measured_after_it(
    returns: list[float], ends: list[RunStatus | None]
) -> None:
    """Whatever becomes of the runs that go on: the first rung's ranking is what it was."""
    values = np.array(returns).reshape(8, 3)
    runs = [run(i // 2, [float(values[i, 0])], i % 2) for i in range(8)]
    first = climbed(runs)
    best = {each.label for each in first.climbs[0].best}
    later = [
        run(i // 2, list(map(float, values[i, : 2 if end else 3])), i % 2, timesteps=STEPS,
            status=end or RunStatus.SUCCEEDED) if LABELS[i // 2] in best else runs[i]
        for i, end in enumerate(ends)
    ]  # fmt: skip
    ladder = climbed(later)
    assert ladder.climbs[0] == first.climbs[0]
    assert wanted([ladder]).keys() <= {("Pendulum", label) for label in best}
