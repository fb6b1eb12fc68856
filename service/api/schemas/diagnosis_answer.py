"""Diagnoses, as answers show them."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Self

from pydantic import BaseModel, ConfigDict, Field

from algorithms.diagnostics.medians import Medians
from service.analysis.diagnosis import (
    DiagnosedCell,
    FigureName,
    diagnosed_cells,
    figures_of,
    remarks,
)
from service.api.schemas.number import finite_or_none
from service.api.schemas.requests.texts import Name
from service.model.diagnosis import Diagnosis
from service.model.run import Run

MAX_SEEDS = 16


class CellsQuery(BaseModel):
    """Which runs of a sweep to diagnose."""

    model_config = ConfigDict(extra="forbid")

    seeds: int = Field(
        default=4,
        ge=1,
        le=MAX_SEEDS,
        description="Runs of each cell, at most: the first ones that reached their end.",
    )
    environment: Name | None = Field(default=None, description="This task alone.")


class FindingAnswer(BaseModel):
    """One number of a diagnosis; for several seeds, their median."""

    diagnostic: str = Field(description="smoothing, growth, kinks, critic, target or loss.")
    quantity: str
    horizon: int | None = Field(description="Steps; null where it does not apply.")
    noise: float | None = Field(
        description="Standard deviation of each action's noise; null: none."
    )
    value: float | None = Field(description="Null if it does not exist.")


class DiagnosedCellAnswer(BaseModel):
    """A cell with the findings of its diagnosed runs."""

    label: str = Field(description="Name of its entry in the request.")
    algorithm: str
    environment: str
    seeds: list[int] = Field(description="Seeds of the diagnosed runs.")
    findings: list[FindingAnswer]

    @classmethod
    def of(cls, cell: DiagnosedCell) -> Self:
        """Show a cell."""
        findings = [
            FindingAnswer(
                diagnostic=diagnostic,
                quantity=quantity,
                horizon=horizon,
                noise=noise,
                value=finite_or_none(value),
            )
            for (diagnostic, quantity, horizon, noise), value in cell.medians.items()
        ]
        return cls(
            label=cell.label,
            algorithm=cell.algorithm,
            environment=cell.environment,
            seeds=list(cell.seeds),
            findings=findings,
        )

    @property
    def medians(self) -> Medians:
        """The findings by name, NaN for those that do not exist."""
        return {
            (each.diagnostic, each.quantity, each.horizon, each.noise): (
                float("nan") if each.value is None else each.value
            )
            for each in self.findings
        }


class DiagnosisFigureAnswer(BaseModel):
    """A figure that can be drawn of these findings."""

    name: FigureName
    title: str
    definition: str = Field(description="What it shows.")
    reading: str = Field(description="How to read it.")


class DiagnosisAnswer(BaseModel):
    """Where gradients help a run or the runs of a sweep: findings, and diagnoses still to come."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "runs": 8,
                    "waiting": 1,
                    "done": 6,
                    "failed": 1,
                    "cells": [
                        {
                            "label": "hybrid-ddpg",
                            "algorithm": "hybrid-ddpg",
                            "environment": "Pendulum",
                            "seeds": [0, 1, 2, 3],
                            "findings": [
                                {
                                    "diagnostic": "growth",
                                    "quantity": "median_norm",
                                    "horizon": 8,
                                    "noise": None,
                                    "value": 0.41,
                                }
                            ],
                        }
                    ],
                    "figures": [
                        {
                            "name": "growth",
                            "title": "Growth of gradients through time",
                            "definition": "The norm of d s(t+H) / d s(t) ...",
                            "reading": "If it grows with each doubling of H, ...",
                        }
                    ],
                    "remarks": [],
                    "problems": ["The diagnosis of run 3f9a0c51b7de-17 was ended: ..."],
                    "links": {"self": "/api/v1/sweeps/3f9a0c51b7de/diagnosis"},
                }
            ]
        }
    )

    runs: int = Field(description="Runs that can be diagnosed: those that have reached their end.")
    waiting: int = Field(description="Diagnoses that were requested and are not made yet.")
    done: int
    failed: int = Field(description="Diagnoses that failed; `problems` says why.")
    cells: list[DiagnosedCellAnswer]
    figures: list[DiagnosisFigureAnswer]
    remarks: list[str] = Field(description="What the figures cannot show, and why.")
    problems: list[str] = Field(description="Why diagnoses failed, each reason once.")
    links: dict[str, str]

    @classmethod
    def of(cls, link: str, diagnoses: Sequence[Diagnosis], label: Callable[[Run], str]) -> Self:
        """Show the diagnoses of runs; `label` names the entry of a run."""
        cells = diagnosed_cells(diagnoses, label)
        problems = [each.problem for each in diagnoses if each.problem]
        figures = figures_of(cells)
        return cls(
            runs=len(diagnoses),
            waiting=sum(each.is_waiting for each in diagnoses),
            done=sum(each.findings is not None for each in diagnoses),
            failed=len(problems),
            cells=[DiagnosedCellAnswer.of(cell) for cell in cells],
            figures=[
                DiagnosisFigureAnswer(name=name, **asdict(text)) for name, text in figures.items()
            ],
            remarks=list(remarks(cells)),
            problems=list(dict.fromkeys(problems)),
            links={"self": link, **{name: f"{link}/{name}.svg" for name in figures}},
        )
