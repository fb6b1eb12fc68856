"""The score of every run of a sweep, as answers show it."""

from collections.abc import Iterator, Sequence
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field

from service.analysis.statistics.score import Score
from service.analysis.statistics.scores import CellScores
from service.api.schemas.number import Numbers, numbers
from service.api.schemas.tabular import Tabular


class CellScoresAnswer(BaseModel):
    """The runs of one entry in one environment."""

    environment: str
    label: str
    algorithm: str
    seeds: list[int]
    values: Numbers = Field(
        description="In the order of `seeds`; null where a run has not reached its end, or the "
        "score is not finite."
    )


class ScoresAnswer(Tabular):
    """The scores of a sweep."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "sweep": "3f9a0c51b7de",
                    "score": "final",
                    "normalized": True,
                    "cells": [
                        {
                            "environment": "Pendulum",
                            "label": "ddpg",
                            "algorithm": "ddpg",
                            "seeds": [0, 1],
                            "values": [0.731, None],
                        }
                    ],
                }
            ]
        }
    )

    sweep: str
    score: Score
    normalized: bool
    cells: list[CellScoresAnswer]

    @classmethod
    def of(
        cls, sweep_id: str, score: Score, cells: Sequence[CellScores], *, normalized: bool
    ) -> Self:
        """Show scores."""
        shown = [
            CellScoresAnswer(
                environment=cell.spec.environment,
                label=cell.label,
                algorithm=cell.spec.algorithm,
                seeds=list(cell.seeds),
                values=numbers(cell.values),
            )
            for cell in cells
        ]
        return cls(sweep=sweep_id, score=score, normalized=normalized, cells=shown)

    def records(self) -> Iterator[dict[str, Any]]:
        """Yield a record a run."""
        for cell in self.cells:
            told = {name: getattr(cell, name) for name in ("environment", "label", "algorithm")}
            for seed, value in zip(cell.seeds, cell.values, strict=True):
                yield {**told, "seed": seed, self.score: value}
