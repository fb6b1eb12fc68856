"""Pairs: what counts, how it is scored, and of which looks all runs have ended."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from service.analysis.question.pairs import Counts, Pairs, all_pairs
from service.model.inquiry.question import Question
from service.model.processor import UNKNOWN
from service.model.run import RunStatus
from service.model.run_curve import RunCurve
from tests.service.scored import ByAlgorithm, run_curve
from workers.messages.random_return import RandomReturn

ZEROS = {("Pendulum", 1): RandomReturn("Pendulum", 1, -100.0, -101.0, -99.0, 1000)}
QUESTION = Question((0, 1), ("hybrid-ddpg",), "ddpg", score="final", batch=1, max_seeds=4)
OURS, THEIRS = "hybrid-ddpg", "ddpg"


def pairs_of(
    runs: Sequence[RunCurve], question: Question = QUESTION, zeros: Any = None
) -> list[Pairs]:
    found = ZEROS if zeros is None else zeros
    return all_pairs(runs, ByAlgorithm(runs), question, found, lambda _: 0.0)


def both(seed: int, ours: float, theirs: float, **fields: Any) -> list[RunCurve]:
    """Two runs whose final normalised scores these are; `ours_` fields are of the first."""
    own = {key.removeprefix("ours_"): fields.pop(key) for key in list(fields) if "ours_" in key}
    return [
        run_curve(THEIRS, "Pendulum", seed, [-100.0, 100 * theirs - 100], timesteps=1600, **fields),
        run_curve(OURS, "Pendulum", seed, [-100.0, 100 * ours - 100], timesteps=1600, **own),
    ]


def test_scores_are_subtracted_seed_by_seed_in_the_order_of_the_seeds() -> None:
    [found] = pairs_of([*both(1, 0.75, 0.5), *both(0, 0.5, 0.625)])
    assert (found.environment, found.label, found.place) == ("Pendulum", OURS, 0)
    assert found.differences == pytest.approx([-0.125, 0.25])
    assert found.looks == (Counts(2),)


def test_scores_outside_the_scale_count_as_its_ends() -> None:
    [found] = pairs_of([*both(0, 1.5, 0.25), *both(1, 0.75, -3.0)])
    assert found.differences == pytest.approx([0.75, 0.75])


def test_a_diverged_run_acts_at_random_and_a_failed_one_is_left_out() -> None:
    diverged, failed = RunStatus.DIVERGED, RunStatus.FAILED
    runs = [
        *both(0, 0.9, 0.5, ours_status=diverged),
        *both(1, 0.9, 0.5, status=failed),
        *both(2, 0.9, 0.5, ours_status=RunStatus.CANCELLED),
        *both(3, np.nan, 0.5),
    ]
    [found] = pairs_of(runs)
    assert found.differences == pytest.approx([-0.5, -0.5])
    assert found.looks == (Counts(1, 1, 1), Counts(1, 2, 1), Counts(2, 2, 1))
    assert found.until(1).differences == pytest.approx([-0.5])
    assert found.until(0).n == ()


def test_a_look_ends_with_the_last_of_its_runs() -> None:
    runs = [*both(0, 0.9, 0.5), *both(1, 0.9, 0.5), *both(2, 0.9, 0.5), *both(3, 0.9, 0.5)]
    for status in (RunStatus.RUNNING, RunStatus.QUEUED, RunStatus.PAUSED):
        waiting = [replace(run, status=status) if run.spec.seed == 2 else run for run in runs]
        assert pairs_of(waiting)[0].n == (2,)
    assert pairs_of(runs)[0].n == (2, 3, 4)
    assert pairs_of(runs[:-1])[0].n == (2, 3)  # one of ours is yet to be asked for


def test_seeds_that_the_question_has_not_reached_do_not_count() -> None:
    assert pairs_of([*both(0, 0.9, 0.5), *both(1, 0.9, 0.5), *both(7, 0.1, 0.5)])[0].n == (2,)


def test_without_a_random_return_no_look_has_ended() -> None:
    [found] = pairs_of([*both(0, 0.9, 0.5), *both(1, 0.9, 0.5)], zeros={})
    assert found.n == ()


def test_differences_are_clipped() -> None:
    runs = [*both(0, 0.9, 0.1), *both(1, 0.1, 0.15)]
    [found] = pairs_of(runs, replace(QUESTION, clip=0.25))
    assert found.differences == pytest.approx([0.25, -0.05])


def test_the_area_is_that_of_the_curve() -> None:
    [found] = pairs_of(both(0, 1.0, 0.5), Question((0,), (OURS,), THEIRS, max_seeds=1))
    assert found.differences == pytest.approx([0.25])


def test_seconds_are_compared_as_the_share_that_is_saved() -> None:
    question = replace(QUESTION, score="seconds to 0.5", first=(0, 1, 2, 3))

    def run(algorithm: str, seed: int, values: list[float], **fields: Any) -> RunCurve:
        raw = [100 * value - 100 for value in values]
        return run_curve(algorithm, "Pendulum", seed, raw, **fields)

    runs = [
        run(OURS, 0, [0.1, 0.5, 0.4]), run(THEIRS, 0, [0.1, 0.2, 0.3, 0.6]),
        run(OURS, 1, [0.1]), run(THEIRS, 1, [0.1]),
        run(OURS, 2, [0.1, 0.2]), run(THEIRS, 2, [0.9]),
        run(OURS, 3, [0.9]), run(THEIRS, 3, [0.9], status=RunStatus.DIVERGED),
    ]  # fmt: skip
    assert pairs_of(runs, question)[0].differences == pytest.approx([0.5, 0.0, -1.0, 1.0])


@pytest.mark.parametrize("other", ["znver3", UNKNOWN])
def test_seconds_of_two_processors_are_left_out(other: str) -> None:
    """A worker on a faster machine does not make its learner better."""
    runs = [
        *both(0, 0.9, 0.9, processor=other),
        *both(1, 0.9, 0.9),
        *both(2, 0.9, 0.9, ours_processor="znver3", processor="znver3"),
        *both(3, 0.9, 0.9, processor=other, status=RunStatus.FAILED),
    ]
    of_seconds = replace(QUESTION, score="seconds to 0.5", first=(0, 1, 2, 3))
    assert pairs_of(runs, of_seconds)[0].looks == (Counts(2, 2, unequal=1),)
    of_returns = replace(QUESTION, first=(0, 1, 2, 3))
    assert pairs_of(runs, of_returns)[0].looks == (Counts(3, 1),)


def test_an_entry_is_compared_in_the_tasks_that_it_runs_in() -> None:
    runs = [
        *both(0, 0.9, 0.5),
        run_curve(THEIRS, "MassPoint", 0, [-1.0]),
        run_curve("td3", "Pendulum", 0, [-1.0]),
    ]
    question = replace(QUESTION, compare=("td3", OURS))
    assert [(p.environment, p.label, p.place) for p in pairs_of(runs, question)] == [
        ("Pendulum", "td3", 0),
        ("Pendulum", OURS, 1),
    ]
