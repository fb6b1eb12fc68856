"""What `POST /sweeps/{id}/runs` takes: more seeds, entries or timesteps of a sweep."""

from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from service.api.schemas.requests.sweep_request import (
    MAX_RUNS,
    MAX_TIMESTEPS,
    AlgorithmRequest,
    Listed,
    Seed,
)
from service.api.schemas.requests.texts import Request


class GrowthRequest(Request):
    """More seeds for every curve, more entries for every task, or more timesteps for every run."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"seeds": [16, 17]},
                {"algorithms": [{"name": "sac", "config": {"rate": [0.0003, 0.001]}}]},
                {"timesteps": 80_000},
            ]
        }
    )

    seeds: Annotated[list[Seed], Field(min_length=1, max_length=MAX_RUNS)] | None = Field(
        default=None, description="Seeds that the sweep does not have yet."
    )
    algorithms: Annotated[list[AlgorithmRequest], Listed] | None = Field(
        default=None, description="New entries, as in `POST /sweeps`."
    )
    timesteps: Annotated[int, Field(ge=1, le=MAX_TIMESTEPS)] | None = Field(
        default=None,
        description="Of each run, counted from its start. An extended run has the bits of one "
        "that was as long from the start.",
    )

    @model_validator(mode="after")
    def _one(self) -> Self:
        given = [self.seeds, self.algorithms, self.timesteps]
        if sum(each is not None for each in given) != 1:
            raise ValueError("give exactly one of seeds, algorithms and timesteps")
        return self
