"""A sweep, and a dry run of one, as answers show them."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field

from service.analysis.cost import (
    Basis,
    CellCost,
    about,
    explain,
    total_core_seconds,
    wall_seconds,
)
from service.analysis.figures.paper_figure import PAPER
from service.api.place import here
from service.api.schemas.moment import Moment, as_time
from service.api.schemas.number import finite_or_none
from service.api.schemas.run_answer import MOVES, WeightsAnswer
from service.model.request.entry import Entries
from service.model.request.plan import Plan
from service.model.sweep import RunCounts, Sweep, SweepStatus

NOTICES_TEXT = "Notices on a submission; empty in any other answer."
NOTICE = (
    "algorithms[1] (hybrid-ddpg) has the weights (0, 0) in Pendulum: without gradient terms it is "
    "ddpg, bit for bit, and says nothing of gradient matching. It repeats algorithms[0]."
)


class CellAnswer(BaseModel):
    """What the runs of one curve share."""

    label: str = Field(description="Name of its entry in the request.")
    algorithm: str
    environment: str
    weights: WeightsAnswer
    config: dict[str, Any]
    timesteps: int
    seeds: int


class EntryAnswer(BaseModel):
    """An entry of a request: an algorithm with its settings and one pair of weights."""

    label: str = Field(description="Its name: curves, tables, statistics and runs carry it.")
    algorithm: str
    stated: dict[str, Any] = Field(
        description="Weights, settings and share of the timesteps that it states, by name; the "
        "others are the presets'."
    )


class RunCountsAnswer(BaseModel):
    """The number of runs by status."""

    total: int
    queued: int
    paused: int
    running: int
    succeeded: int
    failed: int
    diverged: int
    cancelled: int

    @classmethod
    def of(cls, counts: RunCounts) -> Self:
        """Show counts."""
        return cls(total=counts.total, **asdict(counts))


class CostAnswer(BaseModel):
    """The estimated cost of runs, and its basis."""

    core_seconds: float | None = Field(description="Of all seeds together; null if not known.")
    basis: Basis = Field(description="Which finished runs the estimate is based on.")
    runs: int = Field(description="The number of those runs.")


class PlannedCellAnswer(CellAnswer):
    """A cell that would be queued."""

    cost: CostAnswer


class EstimateOfCostAnswer(BaseModel):
    """The estimated cost of all cells of known cost together."""

    core_seconds: float | None
    wall_seconds: float | None = Field(
        description="On `workers` workers that do nothing else; null while there are none."
    )
    workers: int = Field(description="Workers that are up now.")
    explanation: str


class DryRunAnswer(BaseModel):
    """What a submission would queue, and its estimated cost."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "runs": {
                        "total": 16,
                        "queued": 16,
                        "paused": 0,
                        "running": 0,
                        "succeeded": 0,
                        "failed": 0,
                        "diverged": 0,
                        "cancelled": 0,
                    },
                    "product": "1 x 1 x 16 seeds = 16 runs, about 2 min",
                    "timesteps": 320_000,
                    "cells": [
                        {
                            "label": "ddpg",
                            "algorithm": "ddpg",
                            "environment": "Pendulum",
                            "weights": {"w1": 0.0, "w2": 0.0},
                            "config": {},
                            "timesteps": 20_000,
                            "seeds": 16,
                            "cost": {"core_seconds": 118.4, "basis": "same settings", "runs": 48},
                        }
                    ],
                    "estimate": {
                        "core_seconds": 118.4,
                        "wall_seconds": 118.4,
                        "workers": 2,
                        "explanation": "1 of 1 cells ...",
                    },
                    "notices": [NOTICE],
                }
            ]
        }
    )

    runs: RunCountsAnswer
    product: str = Field(
        description="The product that gives the number of runs, and about how long they take."
    )
    timesteps: int = Field(description="Environment steps of all runs together.")
    cells: list[PlannedCellAnswer]
    estimate: EstimateOfCostAnswer
    notices: list[str] = Field(description=NOTICES_TEXT)

    @classmethod
    def of(cls, plan: Plan, costs: Sequence[CellCost], workers: int) -> Self:
        """Show a plan and the costs of its cells."""
        cells = [
            PlannedCellAnswer(
                label=entry.label,
                algorithm=cell.algorithm,
                environment=cell.environment,
                weights=WeightsAnswer.of(cell.weights),
                config=dict(cell.config),
                timesteps=cell.timesteps,
                seeds=len(plan.seeds),
                cost=CostAnswer(
                    core_seconds=finite_or_none(cost.core_seconds),
                    basis=cost.basis,
                    runs=cost.runs,
                ),
            )
            for entry, cell, cost in zip(plan.entries, plan.cells, costs, strict=True)
        ]
        counts = RunCountsAnswer.of(RunCounts(queued=plan.runs))
        estimate = EstimateOfCostAnswer(
            core_seconds=finite_or_none(total_core_seconds(costs)),
            wall_seconds=finite_or_none(wall_seconds(costs, workers)),
            workers=workers,
            explanation=explain(costs),
        )
        return cls(
            runs=counts,
            product=", ".join(filter(None, [plan.product, about(wall_seconds(costs, workers))])),
            timesteps=plan.timesteps,
            cells=cells,
            estimate=estimate,
            notices=list(plan.notices),
        )


class WebhookAnswer(BaseModel):
    """The webhook of a sweep, and the state of its delivery."""

    url: str
    delivered_at: Moment | None = Field(description="When the latest end was told or given up.")
    tries: int = Field(description="That have failed since the sweep ended.")
    problem: str = Field(description="Why the last try failed; empty if it succeeded.")


class SweepHead(BaseModel):
    """Fields of a sweep that lists and answers share."""

    id: str
    name: str
    owner: str = Field(description="Who submitted it.")
    created_at: Moment
    priority: int
    status: SweepStatus
    runs: RunCountsAnswer
    progress: float = Field(
        description="Share of the asked timesteps that is done, 0 to 1: a run that reached its end "
        "counts whole, any other as far as it got."
    )
    eta_seconds: float | None
    tags: list[str]
    archived: bool
    links: dict[str, str]

    def __repr__(self) -> str:
        """`<sweep 3f9a0c51b7de 'weights' running, 48 runs, 25%>`."""
        runs, done = self.runs.total, f"{self.progress:.0%}"
        return f"<sweep {self.id} {self.name!r} {self.status.value}, {runs} runs, {done}>"


def head_of(sweep: Sweep) -> dict[str, Any]:
    """Return the fields of a sweep's head, its links aside."""
    return {
        "id": sweep.id,
        "name": sweep.name,
        "owner": sweep.owner,
        "created_at": as_time(sweep.created_at),
        "priority": sweep.priority,
        "status": sweep.status,
        "runs": RunCountsAnswer.of(sweep.runs),
        "progress": sweep.progress,
        "eta_seconds": sweep.eta_seconds,
        "tags": list(sweep.tags),
        "archived": sweep.archived,
    }


class SweepAnswer(SweepHead):
    """A sweep as it stands."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "id": "3f9a0c51b7de",
                    "name": "weights on Pendulum",
                    "owner": "ann",
                    "created_at": "2026-11-24T09:30:00.120000Z",
                    "priority": 0,
                    "status": "running",
                    "runs": {
                        "total": 48,
                        "queued": 16,
                        "paused": 0,
                        "running": 32,
                        "succeeded": 0,
                        "failed": 0,
                        "diverged": 0,
                        "cancelled": 0,
                    },
                    "progress": 0.25,
                    "eta_seconds": 310.5,
                    "tags": ["paper"],
                    "archived": False,
                    "notes": "After the *first* look.",
                    "max_workers": None,
                    "webhook": None,
                    "request": {"name": "weights on Pendulum", "seeds": 16},
                    "entries": [
                        {"label": "ddpg", "algorithm": "ddpg", "stated": {}},
                        {"label": "hybrid-ddpg", "algorithm": "hybrid-ddpg", "stated": {}},
                    ],
                    "notices": [NOTICE],
                    "links": {"self": "/api/v1/sweeps/3f9a0c51b7de"},
                }
            ]
        }
    )

    notes: str = Field(description="Markdown, shown as text.")
    webhook: WebhookAnswer | None
    max_workers: int | None = Field(
        description="Workers that may train its runs at once; null: any number."
    )
    request: Mapping[str, Any] = Field(
        description="The request, with the seeds and entries that were added since."
    )
    entries: list[EntryAnswer] = Field(description="Its entries, in the order of the request.")
    notices: list[str] = Field(description=NOTICES_TEXT)

    @classmethod
    def of(cls, sweep: Sweep, notices: Sequence[str] = ()) -> Self:
        """Show a sweep, with notices if it was submitted just now."""
        link = here(f"/api/v1/sweeps/{sweep.id}")
        figures = figures_of(sweep.request)
        parts = ("runs", "curves", "table", "statistics", "events", *MOVES)
        return cls(
            **head_of(sweep),
            notes=sweep.notes,
            max_workers=sweep.max_workers,
            webhook=_webhook(sweep),
            request=sweep.request,
            entries=[
                EntryAnswer(label=entry.label, algorithm=entry.algorithm, stated=entry.stated)
                for entry in Entries(sweep.request).all
            ],
            notices=list(notices),
            links={
                "self": link,
                "page": here(f"/sweeps/{sweep.id}"),
                **{part: f"{link}/{part}" for part in parts},
                "plot": f"{link}/plot.png",
                **{f"figure_{number}": f"{link}/figures/{number}.png" for number in figures},
            },
        )


def _webhook(sweep: Sweep) -> WebhookAnswer | None:
    if sweep.webhook is None:
        return None
    told_at = sweep.webhook_delivered_at
    return WebhookAnswer(
        url=sweep.webhook,
        delivered_at=None if told_at is None else as_time(told_at),
        tries=sweep.webhook_tries,
        problem=sweep.webhook_problem,
    )


def figures_of(request: Mapping[str, Any]) -> list[str]:
    """The numbers of the paper's figures that a sweep has runs for."""
    everywhere = request.get("environments", ())
    environments = {
        algorithm["name"]: algorithm.get("environments") or everywhere
        for algorithm in request.get("algorithms", ())
    }
    return [number for number, each in PAPER.items() if each.has_runs(environments)]
