"""The tuning's definition: every sweep can be submitted, and the presets are read off it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from algorithms import catalogue
from service.api.schemas.curves_answer import CurveAnswer, CurvesAnswer, PanelAnswer
from service.api.schemas.requests.sweep_request import SweepRequest
from service.api.schemas.run_answer import WeightsAnswer
from service.api.submission.plan import plan as plan_in
from service.model.inquiry.search import Rung
from service.model.request.plan import Plan
from service.paper.search import tuning
from service.paper.search.tuning import Outcome, best
from workers.messages.run_spec import Weights

WORKER_MEMORY = 16 * 2**30
RESULTS = Path(__file__).parents[4] / "results"


def plan(request: SweepRequest) -> Plan:
    """Return the plan of a sweep for workers that have room for each of its runs."""
    return plan_in(request, WORKER_MEMORY)


def requested(request: dict[str, Any] | None) -> SweepRequest:
    assert request is not None
    return SweepRequest(**request)


def test_every_learner_has_six_cells_a_task() -> None:
    """No learner has a larger budget than another; a cell costs the same seeds and timesteps."""
    for name, space in tuning.SPACES.items():
        for task in space.tasks():
            settings = plan(requested(tuning.settings_search(task, name)))
            assert len(settings.cells) == 6
            assert settings.search is not None
            assert settings.search.seeds == tuple(tuning.SEEDS)
            assert settings.search.rungs == {task: (Rung(6, tuning.TIMESTEPS[task]),)}
            chosen = space.on(task)[0]
            for hybrid in tuning.PAIRS:
                if catalogue.baseline(hybrid) == name:
                    weights = plan(requested(tuning.weights_search(task, hybrid, chosen)))
                    assert len({cell.weights for cell in weights.cells}) == 6
                    assert all(chosen.items() <= cell.config.items() for cell in weights.cells)


def test_what_is_known_is_not_run_again() -> None:
    best, other = tuning.SPACES["sac"].on("Pendulum")[:2]

    def outcome(weights: Weights, runs: int) -> Outcome:
        return Outcome("Pendulum", "hybrid-sac", weights, best, 0.1, 0.2, runs, "a")

    known = [outcome(Weights(1.0, 0.0), 4), outcome(Weights(1.0, 1.0), 3)]

    def wanted(config: dict[str, Any], known: list[Outcome]) -> dict[str, Any] | None:
        return tuning.weights_search("Pendulum", "hybrid-sac", config, known)

    for config in (best, other):
        assert len(plan(requested(wanted(config, known))).cells) == 6, "a search compares all cells"
    everything = [outcome(pair, 4) for pair in tuning.PAIRS["hybrid-sac"]]
    assert wanted(best, [*everything[:-1], outcome(tuning.PAIRS["hybrid-sac"][-1], 3)]) is not None
    assert wanted(best, everything) is None
    assert tuning.is_whole(everything, "Pendulum", "hybrid-sac")
    assert not tuning.is_whole(known, "Pendulum", "hybrid-sac")


def test_the_first_of_the_best_is_chosen() -> None:
    rows = [
        Outcome("Pendulum", "ddpg", Weights(), config, area, 0.0, 4, "a")
        for config, area in zip(
            tuning.SPACES["ddpg"].on("Pendulum"), (0.1, 0.3, 0.3, float("-inf")), strict=False
        )
    ]
    assert best(rows, "Pendulum", "ddpg") is rows[1]
    with pytest.raises(ValueError, match="empty"):
        best(rows, "Pendulum", "sac")


def curve(unfinished: dict[str, int], end: float, mean: Sequence[float | None] = ()) -> CurveAnswer:
    """Ten measurements of 800 timesteps each, the last of them `end`."""
    means = list(mean) or [*[0.0] * 9, end]
    return CurveAnswer(
        algorithm="ddpg",
        weights=WeightsAnswer(w1=0.0, w2=0.0),
        config={"noise": 0.3, "critic_decay": 0.0, "actor_rate": 0.0001},
        label="ddpg",
        runs=4,
        unfinished=unfinished,
        x=[2000.0 * (k + 1) for k in range(10)],
        mean=means,
        low=means,
        high=means,
        n=[4] * 10,
    )


def outcome_of(one: CurveAnswer) -> Outcome:
    [outcome] = tuning.outcomes(
        CurvesAnswer(
            sweep="a",
            metric="return_mean",
            normalized=True,
            band="std",
            x="timesteps",
            definition="",
            panels=[PanelAnswer(environment="Pendulum", random_return=None, curves=[one])],
        )
    )
    return outcome


def test_area_and_end_of_a_cell() -> None:
    """Of 20,000 timesteps the last tenth holds the last of ten measurements."""
    reached = outcome_of(curve({}, 0.8))
    assert reached.area == pytest.approx(0.08)
    assert (reached.end, reached.runs) == (0.8, 4)


@pytest.mark.parametrize(
    ("status", "decided"), [("diverged", 3 + 1), ("failed", 3), ("cancelled", 3), ("running", 3)]
)
def test_a_cell_with_a_run_that_did_not_end_is_not_chosen(status: str, decided: int) -> None:
    """The other three were far ahead. What diverged would again; anything else may be tried."""
    short, whole = outcome_of(curve({status: 1}, 0.9)), outcome_of(curve({}, 0.1))
    assert short.area == short.end == float("-inf")
    assert short.runs == decided
    assert best([short, whole], "Pendulum", "ddpg") is whole


def test_a_mean_that_is_not_known_everywhere_is_not_chosen() -> None:
    assert outcome_of(curve({}, 0.0, mean=[None, *[1.0] * 9])).area == float("-inf")
