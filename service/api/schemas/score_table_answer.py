"""The score table of a sweep, as answers show it: JSON, and CSV with a line a cell."""

import csv
import io
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from service.analysis.statistics.score import Score
from service.analysis.statistics.score_table import ScoreTable, Standing
from service.api.schemas.number import finite_or_none
from service.api.schemas.run_answer import WeightsAnswer
from service.api.schemas.tabular import Tabular

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
COLUMNS = (
    "environment", "label", "algorithm", "w1", "w2", "config", "timesteps",
    "runs", "n", "unfinished", "mean", "std", "low", "high", "is_best",
)  # fmt: skip


class StandingAnswer(BaseModel):
    """The runs of one entry in one environment."""

    algorithm: str
    weights: WeightsAnswer
    config: dict[str, Any]
    timesteps: int
    runs: int
    n: int = Field(description="Runs that count: they reached their end, with a finite score.")
    unfinished: dict[str, int] = Field(
        description="Runs that did not reach their end, by status; they do not count."
    )
    mean: float | None
    std: float | None = Field(description="ddof 1; null for fewer than two values.")
    low: float | None = Field(description="95 % confidence interval of the mean (Student's t).")
    high: float | None
    is_best: bool = Field(
        description="To be set in bold; never where a run of any seed does not count."
    )


class RowAnswer(BaseModel):
    """The row of one entry, in the order of `environments`; null where it has no runs."""

    label: str
    entries: list[StandingAnswer | None]


class ScoreTableAnswer(Tabular):
    """The table of a sweep."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "sweep": "3f9a0c51b7de",
                    "score": "final",
                    "normalized": True,
                    "decimals": 3,
                    "definition": "Mean, standard deviation (ddof 1) and 95 % ...",
                    "environments": ["Pendulum"],
                    "rows": [
                        {
                            "label": "ddpg",
                            "entries": [
                                {
                                    "algorithm": "ddpg",
                                    "weights": {"w1": 0.0, "w2": 0.0},
                                    "config": {},
                                    "timesteps": 20000,
                                    "runs": 16,
                                    "n": 16,
                                    "unfinished": {},
                                    "mean": 0.731,
                                    "std": 0.042,
                                    "low": 0.709,
                                    "high": 0.753,
                                    "is_best": True,
                                }
                            ],
                        }
                    ],
                }
            ]
        }
    )

    sweep: str
    score: Score
    normalized: bool
    decimals: int = Field(description="Digits after the point that decide on bold type.")
    definition: str = Field(description="What the table shows, in words.")
    environments: list[str]
    rows: list[RowAnswer]

    @classmethod
    def of(cls, sweep_id: str, table: ScoreTable) -> "ScoreTableAnswer":
        """Show a table."""
        rows = [
            RowAnswer(label=row.label, entries=[_entry(each) for each in row.standings])
            for row in table.rows
        ]
        return cls(
            sweep=sweep_id,
            score=table.score,
            normalized=table.normalized,
            decimals=table.decimals,
            definition=table.definition,
            environments=list(table.environments),
            rows=rows,
        )

    def records(self) -> Iterator[dict[str, Any]]:
        """Yield a record a cell: an entry in a task."""
        for row in self.rows:
            for environment, entry in zip(self.environments, row.entries, strict=True):
                if entry is not None:
                    weights, config = entry.weights.model_dump(), {"config": entry.config}
                    told = entry.model_dump(exclude={"weights", "config"})
                    named = {"environment": environment, "label": row.label}
                    yield named | weights | config | told


def score_table_csv(table: ScoreTable) -> str:
    """Return the table as CSV (RFC 4180), a number that is not defined as an empty cell."""
    file = io.StringIO()
    writer = csv.DictWriter(file, COLUMNS)
    writer.writeheader()
    for column, environment in enumerate(table.environments):
        for row in table.rows:
            if standing := row.standings[column]:
                named = {"environment": inert(environment), "label": inert(row.label)}
                writer.writerow({**named, **_cells(standing)})
    return file.getvalue()


def inert(text: str) -> str:
    """Return text that a spreadsheet shows and never runs: a formula gets a quote in front."""
    return f"'{text}" if text.startswith(FORMULA_STARTS) else text


def _entry(standing: Standing | None) -> StandingAnswer | None:
    if standing is None:
        return None
    spec, sample = standing.spec, standing.sample
    return StandingAnswer(
        algorithm=spec.algorithm,
        weights=WeightsAnswer.of(spec.weights),
        config=dict(spec.config),
        timesteps=spec.timesteps,
        runs=standing.runs,
        n=sample.n,
        unfinished=dict(standing.unfinished),
        mean=finite_or_none(sample.mean),
        std=finite_or_none(sample.std),
        low=finite_or_none(sample.low),
        high=finite_or_none(sample.high),
        is_best=standing.is_best,
    )


def _cells(standing: Standing) -> Mapping[str, object]:
    spec, numbers = standing.spec, asdict(standing.sample)
    return {
        "algorithm": inert(spec.algorithm),
        **spec.weights._asdict(),
        "config": inert(json.dumps(spec.config, sort_keys=True)),
        "timesteps": spec.timesteps,
        "runs": standing.runs,
        "unfinished": ", ".join(f"{n} {status}" for status, n in standing.unfinished.items()),
        "is_best": standing.is_best,
        **{name: "" if math.isnan(value) else value for name, value in numbers.items()},
    }
