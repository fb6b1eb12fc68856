"""results/ stands alone: tables, gains and statistics, worked out again from its files."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import scipy.stats

from service.analysis.statistics.stratified_bootstrap import draw_counts
from service.paper.evaluation import TASKS
from tests.service.analysis.statistics import rliable
from tests.service.paper import published
from tests.service.paper.published import Cell, Floats, measurements, runs, scales
from workers.training.random_play import measure_random_return

BASELINES = {"hybrid-ddpg": "ddpg", "hybrid-ddpg-cosine": "ddpg", "hybrid-sac": "sac"}
STATISTICS = published.document("statistics.json")
TABLE = list(published.lines("table-1.csv"))
COSTS: Mapping[str, Callable[[Mapping[str, Floats]], Floats]] = {
    "timesteps": lambda run: run["timestep"],
    "evaluations": lambda run: run["timestep"] + run["jacobians"],
    "seconds": lambda run: run["seconds"],
}


def mean_with_interval(values: Floats) -> tuple[float, float, float, float]:
    """Mean, standard deviation, and the 95 % interval by Student's t."""
    mean, error = float(values.mean()), float(scipy.stats.sem(values))
    low, high = scipy.stats.t.interval(0.95, len(values) - 1, loc=mean, scale=error)
    return mean, float(values.std(ddof=1)), float(low), float(high)


def drawn(counts: Floats) -> Iterator[np.ndarray[Any, np.dtype[np.int64]]]:
    """Yield the indices of each resample."""
    for row in counts:
        yield np.repeat(np.arange(len(row)), row.astype(np.int64))


def ends(values: Sequence[float] | Floats) -> tuple[float, float]:
    low, high = np.quantile(values, (0.025, 0.975))
    return float(low), float(high)


# What a run came to


def test_every_run_that_was_measured_has_scores() -> None:
    assert {cell: set(seeds) for cell, seeds in runs().items()} == {
        cell: set(seeds) for cell, seeds in measurements().items()
    }
    counted = sum(sweep["runs"]["total"] for sweep in provenance().values())
    assert sum(map(len, runs().values())) == counted == 752


def provenance() -> Mapping[str, Any]:
    sweeps: Mapping[str, Any] = published.document("provenance.json")["sweeps"]
    return sweeps


def test_scores_follow_from_the_measurements() -> None:
    for cell, lines in runs().items():
        for seed, line in lines.items():
            run, asked = measurements()[cell][seed], int(line["timesteps"])
            timesteps, returns = run["timestep"], run["return_mean"]
            in_window = timesteps > 0.9 * asked
            in_window[-1] = True
            along = np.trapezoid(returns, timesteps) / np.ptp(timesteps)
            assert float(line["final"]) == pytest.approx(returns[in_window].mean(), rel=1e-12)
            assert float(line["return_history"]) == run["return_history"][-1]
            assert float(line["area"]) == pytest.approx(along, rel=1e-12)


def test_return_history_is_the_mean_of_the_latest_100() -> None:
    """But for MPC, whose predictions are more than its measurements: one for each action."""
    for cell, seeds in measurements().items():
        for run in seeds.values() if cell[1] != "mpc" else ():
            returns = run["return_mean"]
            means = [returns[max(0, k - 99) : k + 1].mean() for k in range(len(returns))]
            np.testing.assert_allclose(run["return_history"], means, rtol=1e-12)


@pytest.mark.parametrize("environment", list(scales()))
def test_random_returns_are_what_random_actions_earn(environment: str) -> None:
    """To a part of their intervals: the last bits are the processor's."""
    scale, again = scales()[environment], measure_random_return(environment)
    slack = 0.1 * (scale.high - scale.low)
    found = (scale.random, scale.low, scale.high)
    assert found == pytest.approx((again.mean, again.low, again.high), abs=slack)


# Table 1


@pytest.mark.parametrize("line", TABLE, ids=lambda line: f"{line['environment']} {line['label']}")
def test_table_1_follows_from_the_scores(line: Mapping[str, str]) -> None:
    cell = published.cell_of(line["environment"], line["algorithm"], line)
    values = published.scores(cell, "return_history")
    listed = list(runs()[cell].values())
    assert [int(line[name]) for name in ("runs", "ended", "n")] == [len(listed), len(values), 16]
    printed = tuple(float(line[name]) for name in ("mean", "std", "low", "high"))
    assert printed == pytest.approx(mean_with_interval(values), abs=1e-12)
    assert {each["timesteps"] for each in listed} == {line["timesteps"]}
    assert {each["config"] for each in listed} == {line["config"]}


def test_the_best_of_a_task_are_bold() -> None:
    for task in TASKS:
        means = {
            line["label"]: round(float(line["mean"]), 3)
            for line in TABLE
            if line["environment"] == task
        }
        bold = {
            line["label"]
            for line in TABLE
            if line["environment"] == task and line["is_best"] == "True"
        }
        assert bold == {label for label, mean in means.items() if mean == max(means.values())}


def test_table_1_as_text_is_the_same() -> None:
    text = (published.RESULTS / "table-1.md").read_text().replace("\\", "")
    head, _, *body = [line.strip("| ").split(" | ") for line in text.splitlines() if "|" in line]
    assert head == TASKS
    shown = {
        (task, label): entry
        for label, *entries in body
        for task, entry in zip(TASKS, entries, strict=True)
    }
    for line in TABLE:
        mean = f"{float(line['mean']):.3f}"
        bold = f"**{mean}**" if line["is_best"] == "True" else mean
        entry = shown.pop((line["environment"], line["label"]))
        assert entry == f"{bold} ± {float(line['std']):.3f} ({line['n']})"
    assert set(shown.values()) == {"–"}


# Gains


def cut(x: Floats, y: Floats, end: float) -> float:
    """The mean of y along x, up to an end."""
    kept = x <= end
    if kept.sum() == 1:
        return float(y[kept][0])
    return float(np.trapezoid(y[kept], x[kept]) / np.ptp(x[kept])) if kept.any() else np.nan


def differences(cell: Cell, baseline: Cell, cost: str) -> Floats:
    """What each seed gains over its baseline at equal cost, in units of the normalised scale."""
    found = []
    for seed, run in measurements()[cell].items():
        other = measurements()[baseline][seed]
        ours, theirs = COSTS[cost](run), COSTS[cost](other)
        end = min(ours[-1], theirs[-1])
        gained = cut(ours, run["return_mean"], end) - cut(theirs, other["return_mean"], end)
        found.append(gained / scales()[cell[0]].unit)
    return np.array(found)


@pytest.mark.parametrize(
    "line",
    list(published.lines("gains.csv")),
    ids=lambda line: f"{line['environment']} {line['algorithm']} {line['cost']}",
)
def test_gains_follow_from_the_measurements(line: Mapping[str, str]) -> None:
    cell = published.cell_of(line["environment"], line["algorithm"], line)
    d = differences(cell, published.cell(cell[0], BASELINES[cell[1]]), line["cost"])
    low, high = ends([d[chosen].mean() for chosen in drawn(draw_counts(len(d), 0))])
    assert (int(line["n"]), int(line["wins"])) == (len(d), (d > 0).sum())
    printed = [float(line[name]) for name in ("mean", "low", "high")]
    assert printed == pytest.approx([d.mean(), low, high], abs=0.6e-5)


# Statistics


def matrix(statistics: Mapping[str, Any], label: str) -> Floats:
    """The scores of a label, which is an algorithm here: [runs, tasks]."""
    score = statistics.get("score", "return_history")  # the only one, when nothing said which
    cells = [published.cell(task, label) for task in statistics["tasks"]]
    return np.stack([published.scores(cell, score) for cell in cells], axis=1)


def resamples(scores: Floats) -> Iterator[Floats]:
    """Yield the scores of every resample: runs are drawn in each task by itself."""
    drawings = [drawn(draw_counts(len(scores), task)) for task in range(scores.shape[1])]
    for chosen in zip(*drawings, strict=True):
        yield np.stack([scores[rows, task] for task, rows in enumerate(chosen)], axis=1)


def resampled_interval(scores: Floats, of: Callable[[Floats], float]) -> tuple[float, float]:
    return ends([of(each) for each in resamples(scores)])


@pytest.fixture(params=list(STATISTICS))
def statistics(request: pytest.FixtureRequest) -> Mapping[str, Any]:
    found: Mapping[str, Any] = STATISTICS[request.param]
    return found


def labels(statistics: Mapping[str, Any]) -> list[str]:
    return [entry["label"] for entry in statistics["interquartile_mean"]["values"]]


def test_common_tasks_are_those_that_all_ran_in(statistics: Mapping[str, Any]) -> None:
    where = {
        label: {cell[0] for cell in runs() if cell[1] == label} for label in labels(statistics)
    }
    common = set.intersection(*where.values())
    assert set(statistics["tasks"]) == common - {"MassPoint"}
    lacking = {task: [label for label in where if task not in where[label]] for task in TASKS}
    told = {entry["environment"]: entry["labels"] for entry in statistics["lacking"]}
    asked = set.union(*where.values()) - {"MassPoint"}
    assert told == {task: lacking[task] for task in TASKS if task in asked - common}


def test_interquartile_means_follow_from_the_scores(statistics: Mapping[str, Any]) -> None:
    for entry in statistics["interquartile_mean"]["values"]:
        scores = matrix(statistics, entry["label"])
        assert entry["n"] == scores.size
        assert entry["value"] == pytest.approx(rliable.aggregate_iqm(scores), abs=1e-12)
        low, high = resampled_interval(scores, rliable.aggregate_iqm)
        assert (entry["low"], entry["high"]) == pytest.approx((low, high), abs=1e-12)


def test_probabilities_of_improvement_follow_from_the_scores(
    statistics: Mapping[str, Any],
) -> None:
    pairs = statistics["probability_of_improvement"]["pairs"]
    assert [(pair["x"], pair["y"]) for pair in pairs] == list(combinations(labels(statistics), 2))
    for pair in pairs:
        x, y = (matrix(statistics, pair[name]) for name in "xy")
        wins = np.array(
            [(a[:, None] > b) + 0.5 * (a[:, None] == b) for a, b in zip(x.T, y.T, strict=True)]
        )
        own = np.diagonal(wins, axis1=1, axis2=2).T  # [runs, tasks], of equal seed
        value = rliable.probability_of_improvement(x, y)
        assert pair["all_pairs"]["value"] == pytest.approx(value, abs=1e-12)
        assert pair["same_seeds"]["value"] == pytest.approx(own.mean(), abs=1e-12)
        again = resampled_interval(own, np.mean)
        assert (pair["same_seeds"]["low"], pair["same_seeds"]["high"]) == pytest.approx(again)
        again = ends(np.mean([drawn_wins(task, k) for k, task in enumerate(wins)], axis=0))
        assert (pair["all_pairs"]["low"], pair["all_pairs"]["high"]) == pytest.approx(again)


def drawn_wins(wins: Floats, task: int) -> Floats:
    """The share of pairs won in each resample, which draws the same seeds of both."""
    counts = draw_counts(len(wins), task)
    return np.array([wins[np.ix_(rows, rows)].mean() for rows in drawn(counts)])


def test_performance_profiles_follow_from_the_scores(statistics: Mapping[str, Any]) -> None:
    found = statistics["performance_profiles"]
    scores = {label: matrix(statistics, label) for label in labels(statistics)}
    values = np.concatenate([each.ravel() for each in scores.values()])
    lowest = max(min(values.min(), 0.0), -1.0)
    thresholds = np.linspace(lowest, max(values.max(), 1.0), len(found["thresholds"]))
    np.testing.assert_allclose(found["thresholds"], thresholds, rtol=1e-8)
    for profile in found["profiles"]:
        own = scores[profile["label"]]
        shares = [rliable.run_score_deviation(own, threshold) for threshold in thresholds]
        np.testing.assert_allclose(profile["share"], shares, atol=1e-8)
        drawn_shares = [(each[..., None] > thresholds).mean(axis=(0, 1)) for each in resamples(own)]
        low, high = np.quantile(drawn_shares, (0.025, 0.975), axis=0)
        np.testing.assert_allclose([profile["low"], profile["high"]], [low, high], atol=1e-8)


def test_paired_differences_follow_from_the_measurements(statistics: Mapping[str, Any]) -> None:
    for entry in statistics["paired_differences"]["values"]:
        ours, theirs = (
            published.cell(entry["environment"], entry[name]) for name in ("label", "baseline")
        )
        d = differences(ours, theirs, "timesteps")
        assert (entry["n"], entry["wins"]) == (len(d), (d > 0).sum())
        printed = [entry[name] for name in ("mean", "std", "low", "high")]
        assert printed == pytest.approx(mean_with_interval(d), abs=1e-9)
