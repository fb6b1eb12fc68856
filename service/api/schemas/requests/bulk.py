"""Many moves in one request."""

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from service.api.schemas.requests.sweep_edit import distinct
from service.api.schemas.requests.texts import Name, Request
from service.store.claiming.bulk import BulkMove

MAX_MOVED = 1000


class BulkRequest(Request):
    """A move, and the sweeps and runs to move."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"move": "cancel", "ids": ["3f9a0c51b7de-17"]}]}
    )

    move: BulkMove = Field(description="delete, archive and unarchive are for sweeps alone.")
    ids: Annotated[
        list[Name], Field(min_length=1, max_length=MAX_MOVED), AfterValidator(distinct)
    ] = Field(description="Ids of sweeps and of runs.")


class RefusalAnswer(BaseModel):
    """Why one was not moved."""

    id: str
    reason: str


class BulkAnswer(BaseModel):
    """Which were moved, and why the others were not."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "moved": ["3f9a0c51b7de-17"],
                    "refused": [
                        {
                            "id": "3f9a0c51b7de-18",
                            "reason": "run 3f9a0c51b7de-18 has already succeeded",
                        }
                    ],
                }
            ]
        }
    )

    moved: list[str]
    refused: list[RefusalAnswer]


class DeletionAnswer(BaseModel):
    """A sweep that is gone; its files and rows follow within seconds."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"id": "3f9a0c51b7de", "runs": 48}]})

    id: str
    runs: int = Field(description="Number of runs that it had.")
