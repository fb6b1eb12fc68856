"""What `POST /sweeps` takes as a sweep's search."""

from pydantic import Field

from service.api.schemas.requests.texts import Request
from service.model.inquiry.search import SearchScore

MAX_BUDGET = 10**12


class SearchRequest(Request):
    """A search: the sweep's best entry in each task, by successive halving."""

    budget: int = Field(
        ge=1,
        le=MAX_BUDGET,
        description="Timesteps of all runs together, at most. A larger one means more seeds.",
    )
    reduction: int = Field(
        default=3, ge=2, le=100, description="One in this many entries goes on to the next rung."
    )
    score: SearchScore = Field(
        default="area",
        description="Score that compares entries: mean over seeds, up to the rung's timesteps.",
    )
