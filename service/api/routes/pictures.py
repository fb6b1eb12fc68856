"""Pictures of tasks, drawn in the process beside the service, which may run their code."""

from typing import Annotated, Any

from fastapi import APIRouter
from fastapi import Path as PathParameter
from pydantic import BaseModel, ConfigDict, Field

from physics.parameter import name_of
from service.api.access.authority import MAY_SEE_SHARED
from service.api.context import TheCaller, TheShelf, TheSide, TheStore
from service.api.load.side_process import BusyError, TooSlowError
from service.api.refusals.problems import ImpossibleMove, NotFound, ServiceBusy
from service.api.revalidation import TaggedRoute
from service.api.routes.catalogue import names_in
from service.api.schemas.requests.texts import MAX_NAME
from service.api.schemas.rollout_answer import Row, StyleAnswer
from service.model.environment import submittable_facts

router = APIRouter(tags=["catalogue"], route_class=TaggedRoute, dependencies=[MAY_SEE_SHARED])

EnvironmentName = Annotated[
    str, PathParameter(max_length=MAX_NAME, examples=["Pendulum", "Pendulum(length=2)"])
]


class PictureAnswer(BaseModel):
    """A task at a start, as shapes: a film of one frame, as that of a rollout."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "styles": [{"shape": "capsule", "role": "body", "radius": 0.05}],
                    "frames": [[[0, 0.0, 0.0, 0.04, -1.0]]],
                    "views": [[-1.3, -1.3, 1.3, 1.3]],
                }
            ]
        }
    )

    styles: list[StyleAnswer]
    frames: list[list[Row]] = Field(
        description="A single frame: its shapes in painting order, style, x, y, x, y, ... in m."
    )
    views: list[Row] = Field(description="Left, bottom, right, top of the frame.")


@router.get("/environments/{environment:path}/picture", response_model=PictureAnswer)
def get_picture(
    environment: EnvironmentName,
    caller: TheCaller,
    store: TheStore,
    shelf: TheShelf,
    side: TheSide,
) -> Any:
    """Draw a task at the start of seed 0; 409 for one that cannot draw itself."""
    try:
        facts = submittable_facts(environment)
    except ValueError as error:
        raise NotFound(f"{error}.") from error
    if caller.sweeps is not None and name_of(environment) not in names_in(caller.sweeps, store):
        raise NotFound(f"No sweep that is shared with you runs in {facts.name}.")
    file = shelf.file_of(environment, facts.version)
    try:
        return side.call("workers.policies.picture:picture", environment, file)
    except ValueError as error:
        raise ImpossibleMove(f"{error}.") from error
    except (BusyError, TooSlowError) as error:
        raise ServiceBusy(f"{facts.name} cannot be drawn now: {error}.") from error
    except EOFError as error:
        raise ServiceBusy(f"{facts.name} cannot be drawn: the drawing process died.") from error
