"""Workers and the queue: what each worker trains, since when, what waits and why."""

from typing import Any, Self

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field

from service.analysis.comparison import grouped
from service.api.access.authority import MAY_READ
from service.api.context import TheStore, TheWorkforce
from service.api.schemas.moment import Moment, as_time
from service.model.occupation import Training, WaitingRuns
from service.model.request.entry import Entries

router = APIRouter(tags=["health"], dependencies=[MAY_READ])

EXAMPLE: dict[str, Any] = {
    "problem": None,
    "workers": [
        {
            "name": "worker-2",
            "is_busy": True,
            "training": [
                {
                    "sweep_id": "3f9a0c51b7de",
                    "sweep_name": "weights on Pendulum",
                    "label": "hybrid-ddpg w1=0.1",
                    "environment": "Pendulum",
                    "runs": 16,
                    "first_run": "3f9a0c51b7de-16",
                    "since": "2026-11-24T09:30:02.020000Z",
                    "timestep": 4_800,
                    "timesteps": 20_000,
                }
            ],
        }
    ],
    "waiting": [
        {
            "sweep_id": "3f9a0c51b7de",
            "sweep_name": "weights on Pendulum",
            "priority": 0,
            "runs": 32,
            "since": "2026-11-24T09:30:00.120000Z",
            "reason": "every worker is busy",
        }
    ],
}


class TrainingAnswer(BaseModel):
    """Runs of one entry in one task that train together."""

    sweep_id: str
    sweep_name: str
    label: str
    environment: str
    runs: int
    first_run: str
    since: Moment
    timestep: int = Field(description="Of the run that is least far.")
    timesteps: int

    @classmethod
    def of(cls, training: Training, entries: Entries) -> Self:
        """Show what a worker trains, of a sweep with those entries."""
        told = {**vars(training), "since": as_time(training.since)}
        return cls.model_validate({**told, "label": entries.label(training)})


class WorkerAnswer(BaseModel):
    """A worker, and what it trains."""

    name: str
    is_busy: bool
    training: list[TrainingAnswer] = Field(description="Empty while it is idle.")


class WaitingAnswer(BaseModel):
    """Runs of one sweep that wait for a worker."""

    sweep_id: str
    sweep_name: str
    priority: int
    runs: int
    since: Moment = Field(description="When the first of them was submitted.")
    reason: str = Field(description="Why they wait.")


class WorkersAnswer(BaseModel):
    """Workers with what they train, and what waits."""

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE]})

    problem: str | None = Field(description="Why no run can start now; null while they can.")
    workers: list[WorkerAnswer]
    waiting: list[WaitingAnswer] = Field(description="In the order of the queue.")


@router.get("/workers")
def list_workers(store: TheStore, workforce: TheWorkforce) -> WorkersAnswer:
    """List workers with what they train, and what waits for one."""
    up, problem = dict(workforce.workers), workforce.problem
    cohorts = store.training()
    entries = {
        sweep: Entries(store.sweep_request(sweep)) for sweep in {each.sweep_id for each in cohorts}
    }
    training = {
        name: [TrainingAnswer.of(each, entries[each.sweep_id]) for each in own]
        for name, own in grouped(cohorts, lambda each: each.worker).items()
    }
    names = sorted({*up, *(each.worker for each in cohorts)})
    has_idle = any(name not in training for name in up)
    return WorkersAnswer(
        problem=problem,
        workers=[
            WorkerAnswer(
                name=name,
                is_busy=up.get(name, False) or name in training,
                training=training.get(name, []),
            )
            for name in names
        ],
        waiting=[
            WaitingAnswer.model_validate(
                {
                    **vars(each),
                    "since": as_time(each.since),
                    "reason": reason(each, place, problem, has_idle=has_idle),
                }
            )
            for place, each in enumerate(store.waiting_sweeps())
        ],
    )


def reason(waiting: WaitingRuns, place: int, problem: str | None, *, has_idle: bool) -> str:
    """Say why runs wait that stand at that place in the queue."""
    if waiting.later == waiting.runs:
        return "they lost their worker and are tried again in a moment"
    if problem:
        return problem
    if has_idle:
        return "a worker is about to take them"
    if place > 0:
        return (
            "every worker is busy, and others go first: of a higher priority, or submitted before"
        )
    return "every worker is busy"
