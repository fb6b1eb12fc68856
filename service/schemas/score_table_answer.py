"""Table 1 of a sweep, as answers show it: JSON, and CSV with a line per entry."""

import csv
import io
import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from service.schemas.number import finite_or_none
from service.schemas.run_answer import WeightsAnswer
from service.statistics.score_table import Entry, ScoreTable

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
COLUMNS = (
    "environment", "label", "algorithm", "w1", "w2", "config", "timesteps",
    "runs", "ended", "n", "mean", "std", "low", "high", "is_best",
)  # fmt: skip


class EntryAnswer(BaseModel):
    """The runs of one algorithm with its settings in one environment."""

    algorithm: str
    weights: WeightsAnswer
    config: dict[str, Any]
    timesteps: int
    runs: int
    ended: int = Field(description="Runs that are final.")
    n: int = Field(description="Runs with a finite value.")
    mean: float | None
    std: float | None = Field(description="ddof 1; null for fewer than two values.")
    low: float | None = Field(description="95 % confidence interval of the mean (Student's t).")
    high: float | None
    is_best: bool = Field(description="To be set in bold.")


class RowAnswer(BaseModel):
    """The entries of one label, in the order of `environments`; null where there are no runs."""

    label: str
    entries: list[EntryAnswer | None]


class ScoreTableAnswer(BaseModel):
    """The table of a sweep."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "sweep": "3f9a0c51b7de",
                    "metric": "return_history",
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
                                    "ended": 16,
                                    "n": 16,
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
    metric: str
    normalized: bool
    decimals: int = Field(description="Digits after the point that bold type goes by.")
    definition: str = Field(description="What the table shows, in words.")
    environments: list[str]
    rows: list[RowAnswer]

    @classmethod
    def of(cls, sweep_id: str, table: ScoreTable) -> "ScoreTableAnswer":
        """Show a table."""
        rows = [
            RowAnswer(label=row.label, entries=[_entry(entry) for entry in row.entries])
            for row in table.rows
        ]
        return cls(
            sweep=sweep_id,
            metric=table.metric,
            normalized=table.normalized,
            decimals=table.decimals,
            definition=table.definition,
            environments=list(table.environments),
            rows=rows,
        )


def score_table_csv(table: ScoreTable) -> str:
    """Return the table as CSV (RFC 4180), a number that is not defined as an empty cell."""
    file = io.StringIO()
    writer = csv.DictWriter(file, COLUMNS)
    writer.writeheader()
    for column, environment in enumerate(table.environments):
        for row in table.rows:
            if entry := row.entries[column]:
                named = {"environment": inert(environment), "label": inert(row.label)}
                writer.writerow({**named, **_cells(entry)})
    return file.getvalue()


def inert(text: str) -> str:
    """Return text as a spreadsheet shows it and never runs it: a formula gets a quote in front."""
    return f"'{text}" if text.startswith(FORMULA_STARTS) else text


def _entry(entry: Entry | None) -> EntryAnswer | None:
    if entry is None:
        return None
    spec, sample = entry.spec, entry.sample
    return EntryAnswer(
        algorithm=spec.algorithm,
        weights=WeightsAnswer(w1=spec.weights[0], w2=spec.weights[1]),
        config=dict(spec.config),
        timesteps=spec.timesteps,
        runs=entry.runs,
        ended=entry.ended,
        n=sample.n,
        mean=finite_or_none(sample.mean),
        std=finite_or_none(sample.std),
        low=finite_or_none(sample.low),
        high=finite_or_none(sample.high),
        is_best=entry.is_best,
    )


def _cells(entry: Entry) -> Mapping[str, object]:
    spec, numbers = entry.spec, asdict(entry.sample)
    return {
        "algorithm": inert(spec.algorithm),
        "w1": spec.weights[0],
        "w2": spec.weights[1],
        "config": inert(json.dumps(spec.config, sort_keys=True)),
        "timesteps": spec.timesteps,
        "runs": entry.runs,
        "ended": entry.ended,
        "is_best": entry.is_best,
        **{name: "" if math.isnan(value) else value for name, value in numbers.items()},
    }
