"""A rollout, as answers show it, and what `POST /rollouts` takes."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from physics.drawing import Role
from service.api.schemas.requests.sweep_request import MAX_LISTED, MAX_SEED
from service.api.schemas.requests.texts import Name, Request

Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
Row = list[float]


class RolloutRequest(Request):
    """An episode from a given start."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"run": "3f9a0c51b7de-17", "start": [3.14159, 0.0]}]}
    )

    run: Name
    start: list[Coordinate] = Field(
        min_length=1, max_length=MAX_LISTED, description="A state of the run's task."
    )


class RolloutQuery(BaseModel):
    """Which episode."""

    model_config = ConfigDict(extra="forbid")

    seed: int = Field(
        default=0, ge=0, le=MAX_SEED, description="Seed of the start that the task draws."
    )


class StyleAnswer(BaseModel):
    """What a shape of the film looks like."""

    shape: Literal["capsule", "polygon"]
    role: Role
    radius: float = Field(description="Radius of a capsule, in metres.")


class SurfaceAnswer(BaseModel):
    """MassPoint's critic over p positions and k actions, beside the truth (figure 2)."""

    positions: Row = Field(description="[p]")
    actions: Row = Field(description="[k]")
    value: list[Row] = Field(description="[p, k], the critic's Q.")
    truth: list[Row] = Field(description="[p, k], what simulation measures.")
    policy: Row = Field(description="[p], the action that the actor takes.")


class RolloutAnswer(BaseModel):
    """An episode of T steps of what a run has learned, and its film: T + 1 frames."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "environment": "Pendulum",
                    "timestep": 20000,
                    "dt": 0.05,
                    "states": [[3.1, 0.0], [3.12, 0.42]],
                    "actions": [[0.8]],
                    "rewards": [-9.61],
                    "terminated": False,
                    "contacts": [[]],
                    "surface": None,
                    "styles": [{"shape": "capsule", "role": "body", "radius": 0.05}],
                    "frames": [[[0, 0.0, 0.0, 0.04, -1.0]], [[0, 0.0, 0.0, 0.02, -1.0]]],
                    "views": [[-1.3, -1.3, 1.3, 1.3]],
                }
            ]
        }
    )

    environment: str
    timestep: int = Field(description="How far the run had trained when this policy was written.")
    dt: float = Field(description="Seconds of a step, for playback.")
    states: list[Row] = Field(description="[T + 1, n]")
    actions: list[Row] = Field(description="[T, m], within the box.")
    rewards: Row = Field(description="[T]")
    terminated: bool = Field(description="Whether the task ended it, not the time limit.")
    contacts: list[list[Row]] = Field(
        description="The impulses of contacts in each step: x, y (m), px, py (N s)."
    )
    surface: SurfaceAnswer | None = Field(description="Null for other tasks than MassPoint.")
    styles: list[StyleAnswer]
    frames: list[list[Row]] = Field(
        description="Shapes of each state, in painting order: style, x, y, x, y, ... in metres."
    )
    views: list[Row] = Field(
        description="Left, bottom, right, top of each frame; a single one where all are the same."
    )
