"""The statistics of a sweep, as answers show them: every figure with its definition."""

from collections.abc import Iterator
from typing import Any, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from service.analysis.comparison import NORMALISED_TEXT
from service.analysis.statistics.paired_difference import PairedDifference
from service.analysis.statistics.score import SCORES, Score
from service.analysis.statistics.score_statistics import Profile
from service.analysis.statistics.scores import CellScores
from service.analysis.statistics.stratified_bootstrap import RESAMPLES, Estimate
from service.analysis.statistics.sweep_statistics import (
    Improvement,
    LabelStatistics,
    SweepStatistics,
)
from service.api.schemas.number import Numbers, finite_or_none, numbers
from service.api.schemas.tabular import Tabular

INTERVAL_TEXT = (
    f"Interval: 95 %, stratified bootstrap ({RESAMPLES} resamples of the runs within each task, "
    "percentiles); none where a task has one run only."
)
IQM_TEXT = (
    "Interquartile mean: of all n scores of the common tasks, a quarter (rounded down) at either "
    f"end is left out, the mean of the others taken. {INTERVAL_TEXT}"
)
IMPROVEMENT_TEXT = (
    "Probability that a run of x beats a run of y in a task, a tie counting half, mean over the "
    "common tasks: over all pairs of runs (Mann-Whitney), and over the pairs of equal seed. It "
    f"says how often, not by how much. {INTERVAL_TEXT} Equal seeds are drawn together. Where all "
    "resamples are equal, as where every pair is won, Wilson's interval for a share of that many "
    "pairs."
)
PROFILE_TEXT = (
    "Performance profile: share of the runs whose score exceeds the threshold, mean over the "
    f"common tasks. {INTERVAL_TEXT}"
)
DIFFERENCE_TEXT = (
    "Paired difference: area under the normalised curve of return_mean over timesteps (its mean "
    "along the run, by trapezoids), an entry's minus that of its baseline (the reference that was "
    "asked for, else one of the algorithm that its own extends), over the n "
    "pairs of runs of equal seed that both reached their end, each up to the last timestep that "
    "both have measured. Interval: 95 % of the mean (Student's t). wins: pairs with a difference "
    "above 0."
)


class EstimateAnswer(BaseModel):
    """A statistic with its 95 % interval; null where it is not defined."""

    value: float
    low: float | None
    high: float | None

    @classmethod
    def of(cls, estimate: Estimate) -> Self:
        """Show an estimate."""
        low, high = finite_or_none(estimate.low), finite_or_none(estimate.high)
        return cls(value=estimate.value, low=low, high=high)


class MissingAnswer(BaseModel):
    """A task that is not common to all, and the curves without a score in it."""

    environment: str
    labels: list[str]


class IncompleteAnswer(BaseModel):
    """A cell of a common task of which only the n runs that reached their end count."""

    environment: str
    label: str
    n: int
    runs: int
    unfinished: dict[str, int] = Field(description="The other runs, by status.")


class IQMAnswer(EstimateAnswer):
    """The interquartile mean of one curve's n scores."""

    label: str
    algorithm: str
    n: int


class IQMsAnswer(Tabular):
    """The interquartile means of a sweep."""

    definition: str
    values: list[IQMAnswer]

    def records(self) -> Iterator[dict[str, Any]]:
        """Yield a record an entry."""
        return (each.model_dump() for each in self.values)


class ImprovementAnswer(BaseModel):
    """The probability that x beats y."""

    x: str
    y: str
    all_pairs: EstimateAnswer
    same_seeds: EstimateAnswer | None = Field(description="null if a task has no such pair.")


class ImprovementsAnswer(Tabular):
    """Each pair of curves once; the other way round it is one minus the value."""

    definition: str
    pairs: list[ImprovementAnswer]

    def records(self) -> Iterator[dict[str, Any]]:
        """Yield a record a pair of entries, over all pairs of runs."""
        return ({"x": each.x, "y": each.y, **each.all_pairs.model_dump()} for each in self.pairs)


class ProfileAnswer(BaseModel):
    """One curve's share of runs above each threshold."""

    label: str
    algorithm: str
    share: Numbers
    low: Numbers
    high: Numbers


class ProfilesAnswer(BaseModel):
    """The performance profiles of a sweep."""

    definition: str
    thresholds: Numbers
    profiles: list[ProfileAnswer]


class DifferenceAnswer(BaseModel):
    """A curve minus its baseline in one environment."""

    environment: str
    label: str
    baseline: str
    pairs: int = Field(description="Pairs of runs of equal seed.")
    n: int = Field(description="Those of which both runs reached their end.")
    wins: int
    mean: float | None
    std: float | None
    low: float | None
    high: float | None


class DifferencesAnswer(Tabular):
    """The paired differences of a sweep, environment by environment."""

    definition: str
    values: list[DifferenceAnswer]

    def records(self) -> Iterator[dict[str, Any]]:
        """Yield a record a difference."""
        return (each.model_dump() for each in self.values)


class StatisticsAnswer(BaseModel):
    """The statistics of a sweep's normalised scores."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "sweep": "3f9a0c51b7de",
                    "score": "final",
                    "definition": "Normalised: 0 is ...",
                    "tasks": ["Pendulum"],
                    "lacking": [{"environment": "Acrobot", "labels": ["mpc"]}],
                    "unscored": [],
                    "incomplete": [
                        {"environment": "Pendulum", "label": "ddpg", "n": 15, "runs": 16,
                         "unfinished": {"diverged": 1}}
                    ],
                    "interquartile_mean": {
                        "definition": "Interquartile mean: ...",
                        "values": [
                            {"label": "ddpg", "algorithm": "ddpg", "n": 16,
                             "value": 0.71, "low": 0.69, "high": 0.73}
                        ],
                    },
                    "probability_of_improvement": {
                        "definition": "Probability ...",
                        "pairs": [
                            {"x": "ddpg", "y": "hybrid-ddpg",
                             "all_pairs": {"value": 0.31, "low": 0.2, "high": 0.43},
                             "same_seeds": {"value": 0.25, "low": 0.06, "high": 0.5}}
                        ],
                    },
                    "performance_profiles": {
                        "definition": "Performance profile ...",
                        "thresholds": [0.0, 0.5, 1.0],
                        "profiles": [
                            {"label": "ddpg", "algorithm": "ddpg", "share": [1.0, 0.9, 0.0],
                             "low": [1.0, 0.8, 0.0], "high": [1.0, 1.0, 0.0]}
                        ],
                    },
                    "paired_differences": {
                        "definition": "Paired difference ...",
                        "values": [
                            {"environment": "Pendulum", "label": "hybrid-ddpg", "baseline": "ddpg",
                             "pairs": 16, "n": 16, "wins": 12, "mean": 0.05, "std": 0.06,
                             "low": 0.02, "high": 0.08}
                        ],
                    },
                }
            ]
        }
    )  # fmt: skip

    sweep: str
    score: Score
    definition: str = Field(description="What is compared, in words.")
    tasks: list[str] = Field(description="The tasks in which every curve has a score.")
    lacking: list[MissingAnswer] = Field(description="The other tasks: they do not count.")
    unscored: list[str] = Field(description="Curves without any score: they are left out.")
    incomplete: list[IncompleteAnswer] = Field(
        description="Where some runs have no score: the others' mean is likely to be too high "
        "where those failed or diverged."
    )
    interquartile_mean: IQMsAnswer
    probability_of_improvement: ImprovementsAnswer
    performance_profiles: ProfilesAnswer
    paired_differences: DifferencesAnswer

    @classmethod
    def of(
        cls,
        sweep_id: str,
        score: Score,
        found: SweepStatistics,
        differences: list[PairedDifference],
    ) -> Self:
        """Show statistics."""
        return cls(
            sweep=sweep_id,
            score=score,
            definition=f"Of {SCORES[score].text}, of the runs that reached their end. "
            f"{NORMALISED_TEXT}",
            tasks=list(found.tasks),
            lacking=[
                MissingAnswer(environment=task, labels=labels)
                for task, labels in found.lacking.items()
            ],
            unscored=list(found.unscored),
            incomplete=[_incomplete(cell) for cell in found.incomplete],
            interquartile_mean=IQMsAnswer(
                definition=IQM_TEXT, values=[_iqm(one) for one in found.labels]
            ),
            probability_of_improvement=ImprovementsAnswer(
                definition=IMPROVEMENT_TEXT,
                pairs=[_improvement(each) for each in found.improvements],
            ),
            performance_profiles=ProfilesAnswer(
                definition=PROFILE_TEXT,
                thresholds=numbers(found.thresholds),
                profiles=[_profile(one, one.profile) for one in found.labels],
            ),
            paired_differences=DifferencesAnswer(
                definition=DIFFERENCE_TEXT, values=[_difference(each) for each in differences]
            ),
        )


def _incomplete(cell: CellScores) -> IncompleteAnswer:
    return IncompleteAnswer(
        environment=cell.spec.environment,
        label=cell.label,
        n=int(np.isfinite(cell.values).sum()),
        runs=len(cell.values),
        unfinished=cell.unfinished,
    )


def _iqm(one: LabelStatistics) -> IQMAnswer:
    shown = EstimateAnswer.of(one.iqm)
    return IQMAnswer(
        label=one.label,
        algorithm=one.algorithm,
        n=one.runs,
        value=shown.value,
        low=shown.low,
        high=shown.high,
    )


def _improvement(each: Improvement) -> ImprovementAnswer:
    paired = each.same_seeds
    return ImprovementAnswer(
        x=each.x,
        y=each.y,
        all_pairs=EstimateAnswer.of(each.all_pairs),
        same_seeds=None if paired is None else EstimateAnswer.of(paired),
    )


def _profile(one: LabelStatistics, profile: Profile) -> ProfileAnswer:
    return ProfileAnswer(
        label=one.label,
        algorithm=one.algorithm,
        share=numbers(profile.share),
        low=numbers(profile.low),
        high=numbers(profile.high),
    )


def _difference(each: PairedDifference) -> DifferenceAnswer:
    difference = each.difference
    return DifferenceAnswer(
        environment=each.environment,
        label=each.label,
        baseline=each.baseline,
        pairs=each.pairs,
        n=difference.n,
        wins=each.wins,
        mean=finite_or_none(difference.mean),
        std=finite_or_none(difference.std),
        low=finite_or_none(difference.low),
        high=finite_or_none(difference.high),
    )
