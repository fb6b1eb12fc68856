"""results/ stands alone: tables, gains and statistics, worked out again from its files.

The files are those of an evaluation that has ended, or of one that goes on.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
import scipy.stats

from service.analysis.statistics.stratified_bootstrap import draw_counts
from service.paper.differences import FAMILIES
from service.paper.evaluation import FEWER_SEEDS, TASKS
from tests.service.analysis.statistics import rliable
from tests.service.paper import published
from tests.service.paper.published import Cell, Floats, measurements, runs, scales
from workers.training.random_play import measure_random_return

BASELINES = {
    "hybrid-ddpg": "ddpg",
    "hybrid-ddpg-cosine": "ddpg",
    "hybrid-ddpg-robust": "ddpg",
    "hybrid-td3": "td3",
    "hybrid-sac": "sac",
}
STATISTICS = published.document("statistics.json")
TABLE = list(published.lines("table-1.csv"))
COSTS: Mapping[str, Callable[[Mapping[str, Floats]], Floats]] = {
    "timesteps": lambda run: run["timestep"],
    "evaluations": lambda run: run["timestep"] + run["jacobians"],
    "seconds": lambda run: run["seconds"],
}


def mean_with_interval(values: Floats) -> tuple[float, float, float, float]:
    """Mean, standard deviation, and the 95 % interval by Student's t; NaN where there is none."""
    if len(values) < 2:
        return (*values, *[np.nan] * 4)[:4]
    mean, error = float(values.mean()), float(scipy.stats.sem(values))
    reach = float(scipy.stats.t.ppf(0.975, len(values) - 1)) * error
    return mean, float(values.std(ddof=1)), mean - reach, mean + reach


def drawn(counts: Floats) -> Iterator[np.ndarray[Any, np.dtype[np.int64]]]:
    """Yield the indices of each resample."""
    for row in counts:
        yield np.repeat(np.arange(len(row)), row.astype(np.int64))


def ends(values: Sequence[float] | Floats) -> tuple[float, float]:
    low, high = np.quantile(values, (0.025, 0.975))
    return float(low), float(high)


# What a run came to


def test_every_run_that_was_measured_has_scores() -> None:
    for cell, seeds in measurements().items():
        assert set(seeds) <= set(runs()[cell])
    for cell, lines in runs().items():
        measured = {seed for seed, line in lines.items() if line["final"]}
        assert measured == set(measurements().get(cell, ()))
        assert set(published.ended(cell)) <= measured
    counted = sum(sweep["runs"]["total"] for sweep in provenance().values())
    assert sum(map(len, runs().values())) == counted


def provenance() -> Mapping[str, Any]:
    sweeps: Mapping[str, Any] = published.document("provenance.json")["sweeps"]
    return sweeps


def test_scores_follow_from_the_measurements() -> None:
    for cell, seeds in measurements().items():
        for seed, run in seeds.items():
            line = runs()[cell][seed]
            timesteps, returns = run["timestep"], run["return_mean"]
            in_window = timesteps > 0.9 * int(line["timesteps"])
            in_window[-1] = True
            area = cut(timesteps, returns, timesteps[-1])
            assert float(line["final"]) == pytest.approx(returns[in_window].mean(), rel=1e-12)
            assert float(line["return_history"]) == run["return_history"][-1]
            assert float(line["area"]) == pytest.approx(area, rel=1e-12)


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
    cell = published.cell_of(line)
    values = published.scores(cell, "return_history")
    listed = list(runs()[cell].values())
    assert [int(line[name]) for name in ("runs", "n")] == [len(listed), len(values)]
    printed = [float(line[name] or "nan") for name in ("mean", "std", "low", "high")]
    assert printed == pytest.approx(mean_with_interval(values), abs=1e-12, nan_ok=True)
    assert {each["timesteps"] for each in listed} == {line["timesteps"]}
    assert {each["config"] for each in listed} == {line["config"]}


def test_the_best_of_a_task_are_bold() -> None:
    """Of the learners all of whose runs have ended."""
    for task in TASKS:
        means = {
            line["label"]: round(float(line["mean"]), 3)
            for line in TABLE
            if line["environment"] == task and line["n"] == line["runs"]
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
        entry = shown.pop((line["environment"], line["label"]))
        n, runs = line["n"], line["runs"]
        told = f"({n})" if n == runs else f"({n} of {runs})"
        mean = f"{float(line['mean'] or 'nan'):.3f}"
        bold = f"**{mean}**" if line["is_best"] == "True" else mean
        spread = f" ± {float(line['std']):.3f}" if line["std"] else ""
        assert entry == (f"{bold}{spread} {told}" if line["mean"] else f"– {told}")
    assert set(shown.values()) == {"–"}


# Gains


def cut(x: Floats, y: Floats, end: float) -> float:
    """The mean of y along x, up to an end."""
    kept = x <= end
    if kept.sum() == 1:
        return float(y[kept][0])
    return float(np.trapezoid(y[kept], x[kept]) / np.ptp(x[kept])) if kept.any() else np.nan


def differences(cell: Cell, baseline: Cell, cost: str) -> Floats:
    """What each seed gains over its baseline at equal cost, in units of the normalised scale.

    Nothing of a pair in which one was not measured yet when the other had spent all.
    """
    found = []
    for seed in sorted({*published.ended(cell)} & {*published.ended(baseline)}):
        run, other = measurements()[cell][seed], measurements()[baseline][seed]
        ours, theirs = COSTS[cost](run), COSTS[cost](other)
        end = min(ours[-1], theirs[-1])
        gained = cut(ours, run["return_mean"], end) - cut(theirs, other["return_mean"], end)
        found.append(gained / scales()[cell[0]].unit)
    return np.array([each for each in found if np.isfinite(each)])


GAINS = list(published.lines("gains.csv"))


def gained(line: Mapping[str, str]) -> Floats:
    """The differences that a line is about."""
    environment, algorithm = line["environment"], line["algorithm"]
    cell = environment, algorithm, float(line["w1"]), float(line["w2"])
    return differences(cell, published.cell(environment, BASELINES[algorithm]), line["cost"])


@pytest.mark.parametrize(
    "line", GAINS, ids=lambda line: f"{line['environment']} {line['algorithm']} {line['cost']}"
)
def test_gains_follow_from_the_measurements(line: Mapping[str, str]) -> None:
    d = gained(line)
    assert (int(line["n"]), int(line["wins"])) == (len(d), (d > 0).sum())
    low, high = bootstrapped(d)
    printed = [float(line[name]) for name in ("mean", "low", "high")]
    mean = d.mean() if len(d) else np.nan
    assert printed == pytest.approx([mean, low, high], abs=0.6e-5, nan_ok=True)


def bootstrapped(d: Floats) -> tuple[float, float]:
    if len(d) < 2:
        return np.nan, np.nan
    return ends([d[chosen].mean() for chosen in drawn(draw_counts(len(d), 0))])


@pytest.mark.parametrize(
    "line", GAINS, ids=lambda line: f"{line['environment']} {line['algorithm']} {line['cost']}"
)
def test_simultaneous_intervals_are_students_at_the_level_of_their_family(
    line: Mapping[str, str],
) -> None:
    d, family = gained(line), next(each for each in FAMILIES if line["environment"] in each)
    printed = [float(line[name]) for name in ("bonferroni_low", "bonferroni_high")]
    if len(d) < 2:
        assert np.isnan(printed).all()
        return
    low, high = scipy.stats.ttest_1samp(d, 0).confidence_interval(1 - 0.05 / len(family))
    assert printed == pytest.approx([low, high], abs=0.6e-5, nan_ok=True)


@pytest.mark.parametrize(
    "line", GAINS, ids=lambda line: f"{line['environment']} {line['algorithm']} {line['cost']}"
)
def test_p_is_the_share_of_signs_that_reach_as_far(line: Mapping[str, str]) -> None:
    """A hundred thousand choices of signs, drawn at random, are near all of them."""
    d = gained(line)
    signs = np.random.default_rng(0).choice((-1.0, 1.0), (100_000, len(d)))
    share = np.mean(np.abs(signs @ d) >= abs(d.sum()) - 1e-12)
    assert float(line["p"]) == pytest.approx(share, abs=5 * np.sqrt(share / 1e5) + 1e-4)


def test_p_is_corrected_over_the_tasks_of_a_family() -> None:
    for family in FAMILIES:
        members = [line for line in GAINS if line["environment"] in family]
        for test in {(line["algorithm"], line["cost"]) for line in members}:
            lines = [line for line in members if (line["algorithm"], line["cost"]) == test]
            lines.sort(key=lambda line: float(line["p"]))
            least = 0.0
            for rank, line in enumerate(lines):
                least = max(least, min(1.0, (len(family) - rank) * float(line["p"])))
                assert float(line["holm_p"]) == pytest.approx(least, rel=0.02)


def test_pairs_that_a_run_spoiled_are_told() -> None:
    for line in GAINS:
        environment, algorithm = line["environment"], line["algorithm"]
        cell = environment, algorithm, float(line["w1"]), float(line["w2"])
        ours, theirs = runs()[cell], runs()[published.cell(environment, BASELINES[algorithm])]
        spoiled = {
            seed
            for seed in {*ours} & {*theirs}
            if {"failed", "diverged", "cancelled"} & {ours[seed]["status"], theirs[seed]["status"]}
        }
        assert int(line["failed"]) == len(spoiled)


# Figure 7


@pytest.mark.skipif(
    not (published.RESULTS / "figure-7.csv").exists(), reason="no run of it has ended yet"
)
def test_figure_7_follows_from_the_measurements() -> None:
    """The lines over timesteps, and which runs they are of."""
    lines = list(published.lines("figure-7.csv"))
    assert lines
    for line in lines:
        cells = shown(line["learner"])
        assert (int(line["tasks"]), int(line["runs"])) == (len(cells), sum(map(len, cells)))
        if line["of"] == "interquartile mean by timesteps":
            values = [
                np.interp(float(line["x"]), *run, left=np.nan) for runs in cells for run in runs
            ]
            assert float(line["value"]) == pytest.approx(iqm([np.array(values)]), abs=1e-5)


def shown(learner: str) -> list[list[tuple[Floats, Floats]]]:
    """Shares of ddpg's timesteps and normalised returns of a learner's runs, by task."""
    found = []
    for cell in runs():
        task, name, *_ = cell
        baseline = [*[each for each in runs() if each[:2] == (task, "ddpg")], None][0]
        if name != learner or task == "MassPoint" or baseline is None:
            continue
        if not any(seed < FEWER_SEEDS for seed in published.ended(baseline)):
            continue
        asked, scale = int(runs()[baseline][0]["timesteps"]), scales()[task]
        own = [measurements()[cell][seed] for seed in published.ended(cell) if seed < FEWER_SEEDS]
        found.append([
            (run["timestep"] / asked, (run["return_mean"] - scale.random) / scale.unit)
            for run in own
        ])  # fmt: skip
    return [each for each in found if each]


# Statistics


def task_scores(statistics: Mapping[str, Any], label: str) -> list[Floats]:
    """The scores of a label's ended runs in each common task, by seed."""
    score = statistics.get("score", "return_history")  # the only one, when nothing said which
    cells = [published.cell(task, label) for task in statistics["tasks"]]
    return [published.scores(cell, score) for cell in cells]


def task_seeds(statistics: Mapping[str, Any], label: str) -> list[list[int]]:
    """The seeds of those scores."""
    return [published.ended(published.cell(task, label)) for task in statistics["tasks"]]


def resamples(scores: Sequence[Floats]) -> Iterator[list[Floats]]:
    """Yield the scores of every resample: runs are drawn in each task by itself."""
    drawings = [drawn(draw_counts(len(own), task)) for task, own in enumerate(scores)]
    for chosen in zip(*drawings, strict=True):
        yield [own[rows] for own, rows in zip(scores, chosen, strict=True)]


def resampled_interval(
    scores: Sequence[Floats], of: Callable[[Sequence[Floats]], float]
) -> tuple[float, float] | None:
    """None where a task has one run only."""
    if min(map(len, scores)) < 2:
        return None
    return ends([of(each) for each in resamples(scores)])


def interval_of(entry: Mapping[str, Any]) -> tuple[float, float] | None:
    return None if entry["low"] is None else (entry["low"], entry["high"])


def iqm(scores: Sequence[Floats]) -> float:
    return rliable.aggregate_iqm(np.concatenate(scores))


def mean_of_means(scores: Sequence[Floats]) -> float:
    return float(np.mean([own.mean() for own in scores]))


@pytest.fixture(params=list(STATISTICS))
def statistics(request: pytest.FixtureRequest) -> Mapping[str, Any]:
    found: Mapping[str, Any] = STATISTICS[request.param]
    return {**found, "asked": asked(provenance()[request.param]["request"])}


def asked(request: Mapping[str, Any]) -> dict[str, list[str]]:
    """The tasks that each label was to run in."""
    return {
        algorithm.get("label", algorithm["name"]): (
            algorithm.get("environments") or request["environments"]
        )
        for algorithm in request["algorithms"]
    }


def labels(statistics: Mapping[str, Any]) -> list[str]:
    return [entry["label"] for entry in statistics["interquartile_mean"]["values"]]


def test_common_tasks_are_those_that_all_have_scores_in(statistics: Mapping[str, Any]) -> None:
    where = {
        label: {task for task in tasks if published.ended(published.cell(task, label))}
        for label, tasks in statistics["asked"].items()
    }
    scored = {label: tasks for label, tasks in where.items() if tasks}
    assert set(statistics["unscored"]) == {*where} - {*scored}
    common = set.intersection(*scored.values()) if scored else set()
    assert set(statistics["tasks"]) == common
    told = {entry["environment"]: entry["labels"] for entry in statistics["lacking"]}
    everywhere = {task for tasks in statistics["asked"].values() for task in tasks}
    assert told == {
        task: [
            label for label in statistics["asked"] if label in scored and task not in where[label]
        ]
        for task in everywhere - common
    }


def test_interquartile_means_follow_from_the_scores(statistics: Mapping[str, Any]) -> None:
    for entry in statistics["interquartile_mean"]["values"]:
        scores = task_scores(statistics, entry["label"])
        assert entry["n"] == sum(map(len, scores))
        assert entry["value"] == pytest.approx(iqm(scores), abs=1e-12)
        expected = resampled_interval(scores, iqm)
        assert interval_of(entry) == pytest.approx(expected, abs=1e-12)


def test_probabilities_of_improvement_follow_from_the_scores(
    statistics: Mapping[str, Any],
) -> None:
    pairs = statistics["probability_of_improvement"]["pairs"]
    assert [(pair["x"], pair["y"]) for pair in pairs] == list(combinations(labels(statistics), 2))
    for pair in pairs:
        x, y = (task_scores(statistics, pair[name]) for name in "xy")
        value = np.mean([
            rliable.probability_of_improvement(ours[:, None], theirs[:, None])
            for ours, theirs in zip(x, y, strict=True)
        ])  # fmt: skip
        assert pair["all_pairs"]["value"] == pytest.approx(value, abs=1e-12)
        seeds = [task_seeds(statistics, pair[name]) for name in "xy"]
        wins = [won(ours, theirs) for ours, theirs in zip(x, y, strict=True)]
        own = [same_seeds(*each) for each in zip(wins, *seeds, strict=True)]
        if not all(map(len, own)):
            assert pair["same_seeds"] is None
            continue
        assert pair["same_seeds"]["value"] == pytest.approx(mean_of_means(own), abs=1e-12)
        expected = one_sided(own) or resampled_interval(own, mean_of_means)
        assert interval_of(pair["same_seeds"]) == pytest.approx(expected)
        if seeds[0] == seeds[1] and interval_of(pair["all_pairs"]):
            again = one_sided(wins) or ends(
                np.mean([drawn_wins(task, k) for k, task in enumerate(wins)], axis=0)
            )
            assert interval_of(pair["all_pairs"]) == pytest.approx(again)


def won(ours: Floats, theirs: Floats) -> Floats:
    """Whether each of our runs beats each of theirs; a tie is half a win."""
    wins: Floats = (ours[:, None] > theirs) + 0.5 * (ours[:, None] == theirs)
    return wins


def same_seeds(wins: Floats, ours: Sequence[int], theirs: Sequence[int]) -> Floats:
    """The wins among pairs of equal seed."""
    both = sorted({*ours} & {*theirs})
    return np.array([wins[ours.index(seed), theirs.index(seed)] for seed in both])


def one_sided(wins: Sequence[Floats]) -> tuple[float, float] | None:
    """Wilson's interval where every pair of every task is won, or none is: n / (n + z^2)."""
    shares = {float(task.mean()) for task in wins}
    n = len(wins) / np.mean([1 / len(task) for task in wins])
    sure = float(n / (n + NormalDist().inv_cdf(0.975) ** 2))
    return (
        {1.0: (sure, 1.0), 0.0: (0.0, 1.0 - sure)}[shares.pop()]
        if shares in ({0.0}, {1.0})
        else None
    )


def drawn_wins(wins: Floats, task: int) -> Floats:
    """The share of pairs won in each resample, which draws the same seeds of both."""
    counts = draw_counts(len(wins), task)
    return np.array([wins[np.ix_(rows, rows)].mean() for rows in drawn(counts)])


def test_performance_profiles_follow_from_the_scores(statistics: Mapping[str, Any]) -> None:
    found = statistics["performance_profiles"]
    scores = {label: task_scores(statistics, label) for label in labels(statistics)}
    if not scores:
        assert found["profiles"] == []
        return
    values = np.concatenate([task for each in scores.values() for task in each])
    lowest = max(min(values.min(), 0.0), -1.0)
    thresholds = np.linspace(lowest, max(values.max(), 1.0), len(found["thresholds"]))
    np.testing.assert_allclose(found["thresholds"], thresholds, rtol=1e-8)
    for profile in found["profiles"]:
        own = scores[profile["label"]]
        shares = [
            np.mean([rliable.run_score_deviation(task, threshold) for task in own])
            for threshold in thresholds
        ]
        np.testing.assert_allclose(profile["share"], shares, atol=1e-8)
        if min(map(len, own)) < 2:
            assert set(profile["low"]) == {None}
            continue
        drawn_shares = [
            np.mean([(task[:, None] > thresholds).mean(axis=0) for task in each], axis=0)
            for each in resamples(own)
        ]
        low, high = np.quantile(drawn_shares, (0.025, 0.975), axis=0)
        np.testing.assert_allclose([profile["low"], profile["high"]], [low, high], atol=1e-8)


def test_paired_differences_follow_from_the_measurements(statistics: Mapping[str, Any]) -> None:
    for entry in statistics["paired_differences"]["values"]:
        ours, theirs = (
            published.cell(entry["environment"], entry[name]) for name in ("label", "baseline")
        )
        d = differences(ours, theirs, "timesteps")
        assert (entry["n"], entry["wins"]) == (len(d), (d > 0).sum())
        printed = [
            np.nan if entry[name] is None else entry[name]
            for name in ("mean", "std", "low", "high")
        ]
        assert printed == pytest.approx(mean_with_interval(d), abs=1e-9, nan_ok=True)
