"""A sweep of a list: what a row shows, and no more."""

from collections.abc import Sequence
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from service.api.place import here
from service.api.schemas.number import Numbers, numbers
from service.api.schemas.sweep_answer import SweepHead, head_of
from service.model.request.entry import Entries
from service.model.standing import Best
from service.model.sweep import Sweep

SPARKLINE_POINTS = 24


class BestAnswer(BaseModel):
    """The best entry of a sweep in one task, of those whose runs all reached their end."""

    label: str
    environment: str
    score: float = Field(description="Mean final score, normalised.")
    sparkline: Numbers = Field(
        description="Its normalised return_mean, averaged over its runs and thinned; "
        "the last one is the latest."
    )


class ListedSweepAnswer(SweepHead):
    """A sweep of a list."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "id": "3f9a0c51b7de",
                    "name": "weights on Pendulum",
                    "owner": "ann",
                    "created_at": "2026-11-24T09:30:00.120000Z",
                    "priority": 0,
                    "status": "finished",
                    "runs": {
                        "total": 32,
                        "queued": 0,
                        "paused": 0,
                        "running": 0,
                        "succeeded": 32,
                        "failed": 0,
                        "diverged": 0,
                        "cancelled": 0,
                    },
                    "progress": 1.0,
                    "eta_seconds": 0.0,
                    "tags": ["paper"],
                    "archived": False,
                    "algorithms": ["ddpg", "hybrid-ddpg"],
                    "environments": ["Pendulum"],
                    "entry_count": 2,
                    "seeds": 16,
                    "timesteps": 20_000,
                    "best": {
                        "label": "hybrid-ddpg",
                        "environment": "Pendulum",
                        "score": 0.84,
                        "sparkline": [0.1, 0.5, 0.84],
                    },
                    "links": {"self": "/api/v1/sweeps/3f9a0c51b7de"},
                }
            ]
        }
    )

    algorithms: list[str]
    environments: list[str]
    entry_count: int = Field(description="How many entries it compares.")
    seeds: int = Field(description="How many seeds each curve has.")
    timesteps: int | None = Field(
        description="Timesteps of a run, as submitted; null: the presets'."
    )
    best: BestAnswer | None = Field(description="null until all runs of a curve reached their end.")

    @classmethod
    def of(cls, sweep: Sweep, best: Best | None, outline: Sequence[float]) -> Self:
        """Show a sweep with its best cell and the raw curve of that."""
        entries = Entries(sweep.request)
        shown = None
        if best is not None:
            shown = BestAnswer(
                label=entries.all[best.cell.entry].label,
                environment=best.cell.environment,
                score=best.score,
                sparkline=numbers((np.array(outline) - best.start) / best.unit),
            )
        return cls(
            **head_of(sweep),
            algorithms=list(dict.fromkeys(entry.algorithm for entry in entries.all)),
            environments=list(dict.fromkeys(sweep.request["environments"])),
            entry_count=len(entries.all),
            seeds=sweep.runs.total // len(entries.cells),
            timesteps=sweep.request.get("timesteps"),
            best=shown,
            links={
                "self": here(f"/api/v1/sweeps/{sweep.id}"),
                "page": here(f"/sweeps/{sweep.id}"),
            },
        )
