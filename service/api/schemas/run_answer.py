"""A run, as answers show it."""

from collections.abc import Mapping
from datetime import datetime
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field

from service.api.place import here
from service.api.schemas.moment import Moment, as_time
from service.api.schemas.number import Numbers
from service.model.move import TRANSITIONS
from service.model.run import Attempt, Run, RunStatus
from workers.messages.run_spec import Weights

MOVES: tuple[str, ...] = tuple(TRANSITIONS)
STARTING = "its kernels are loaded, or compiled at first use"


class WeightsAnswer(BaseModel):
    """Weights of the critic's gradient terms."""

    w1: float
    w2: float

    @classmethod
    def of(cls, weights: Weights) -> Self:
        """Show weights."""
        return cls(**weights._asdict())

    @property
    def pair(self) -> Weights:
        """The weights that are shown."""
        return Weights(self.w1, self.w2)


class RunAnswer(BaseModel):
    """A run as it stands."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "id": "3f9a0c51b7de-17",
                    "sweep_id": "3f9a0c51b7de",
                    "label": "hybrid-ddpg w1=0.1 w2=0.1",
                    "algorithm": "hybrid-ddpg",
                    "environment": "Pendulum",
                    "environment_version": 1,
                    "seed": 1,
                    "weights": {"w1": 0.1, "w2": 0.1},
                    "config": {},
                    "timesteps": 20_000,
                    "timestep": 4_800,
                    "status": "running",
                    "is_cancelling": False,
                    "reason": "",
                    "attempt": 1,
                    "created_at": "2026-11-24T09:30:00.120000Z",
                    "started_at": "2026-11-24T09:30:02.020000Z",
                    "finished_at": None,
                    "fingerprint": {"numpy": "2.4.6"},
                    "resumed_timestep": 0,
                    "checkpoint_timestep": 4_300,
                    "memory_bytes": 2_400_000,
                    "worked_seconds": None,
                    "links": {"self": "/api/v1/runs/3f9a0c51b7de-17"},
                }
            ]
        }
    )

    id: str
    sweep_id: str
    label: str = Field(description="Name of its entry in the request of its sweep.")
    algorithm: str
    environment: str
    environment_version: int
    seed: int
    weights: WeightsAnswer
    config: Mapping[str, Any]
    timesteps: int
    timestep: int = Field(description="Environment steps reached by the current attempt.")
    status: RunStatus
    is_cancelling: bool
    reason: str
    attempt: int
    created_at: Moment
    started_at: Moment | None
    finished_at: Moment | None
    fingerprint: Mapping[str, Any] | None = Field(
        description="What the bits depend on; mixed_with says how machines of earlier attempts "
        "differed, whose bits the curve begins with."
    )
    resumed_timestep: int | None = Field(
        description="Timestep where the current attempt took over; null until its worker reports."
    )
    checkpoint_timestep: int = Field(description="Of its newest checkpoint; 0 if it has none.")
    memory_bytes: int | None = Field(description="Memory that it may need in its worker.")
    worked_seconds: float | None = Field(
        description="How long workers have worked on it, in its attempts that have ended."
    )
    links: dict[str, str]

    def __repr__(self) -> str:
        """`<run 3f9a0c51b7de-17 ddpg in Pendulum, seed 1, running, 4800/20000>`."""
        where, done = f"{self.label} in {self.environment}", f"{self.timestep}/{self.timesteps}"
        return f"<run {self.id} {where}, seed {self.seed}, {self.status.value}, {done}>"

    @property
    def is_starting(self) -> bool:
        """Whether its worker still loads or compiles its kernels: nothing was trained yet."""
        begun_at = self.timestep if self.resumed_timestep is None else self.resumed_timestep
        return self.status is RunStatus.RUNNING and self.timestep <= begun_at

    @property
    def remark(self) -> str:
        """Its reason; while it is starting, that it is."""
        return self.reason or (STARTING if self.is_starting else "")

    @classmethod
    def of(cls, run: Run, label: str) -> Self:
        """Show a run of the entry of that name."""
        link = here(f"/api/v1/runs/{run.id}")
        links = {
            "self": link,
            "sweep": here(f"/api/v1/sweeps/{run.sweep_id}"),
            "measurements": f"{link}/measurements",
            "attempts": f"{link}/attempts",
            **{move: f"{link}/{move}" for move in MOVES},
        }
        shown: dict[str, Any] = {
            **run.spec.to_json(),
            **vars(run),
            **times(run),
            "label": label,
            "links": links,
        }
        return cls.model_validate(shown)


class ListedRunAnswer(RunAnswer):
    """A run of a list."""

    score: float | None = Field(
        default=None,
        description="Final score, normalised: 0 acts at random, 1 is the best. null unless the run "
        "succeeded and the random return is known.",
    )
    sparkline: Numbers | None = Field(
        default=None, description="return_mean so far, thinned; the last one is the latest."
    )


class AttemptAnswer(BaseModel):
    """One claim of a run by a worker, and how it ended."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "attempt": 1,
                    "worker": "worker-2",
                    "outcome": "lost",
                    "error": "its worker was lost",
                    "log_tail": "",
                    "started_at": "2026-11-24T09:30:02.020000Z",
                    "ended_at": "2026-11-24T09:31:40.500000Z",
                    "fingerprint": {"numpy": "2.4.6"},
                    "resumed_timestep": 0,
                    "note": "",
                }
            ]
        }
    )

    attempt: int
    worker: str
    outcome: str = Field(
        description="running, succeeded, failed, diverged, cancelled, or lost (its worker was)."
    )
    error: str = Field(description="A traceback or a sentence; empty while all is well.")
    log_tail: str = Field(
        description="The last lines, at most 8 KiB, that the worker printed and logged while it "
        "trained the run; also while it trains. The runs of a cohort share it."
    )
    started_at: Moment
    ended_at: Moment | None
    fingerprint: Mapping[str, Any] | None
    resumed_timestep: int | None = Field(description="Timestep where it took over.")
    note: str = Field(description="A remark on its checkpoints; mostly empty.")

    @classmethod
    def of(cls, attempt: Attempt) -> Self:
        """Show an attempt."""
        return cls.model_validate({**vars(attempt), **times(attempt)})


def times(noun: Run | Attempt) -> dict[str, datetime | None]:
    """Return the times of a noun, by the names of their fields."""
    told = {name: value for name, value in vars(noun).items() if name.endswith("_at")}
    return {name: None if value is None else as_time(value) for name, value in told.items()}
