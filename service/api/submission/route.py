"""The route that takes sweeps: it lists all mistakes at once, of form and of meaning."""

from collections.abc import Callable, Coroutine, Iterator
from copy import deepcopy
from typing import Any

from fastapi import Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from pydantic import ValidationError

from service.api.invalid_request import form_faults
from service.api.refusals.problems import Fault, InvalidRequest
from service.api.schemas.requests.sweep_request import SweepRequest
from service.api.submission.plan import part_faults

Body = dict[str, Any]

REQUIRED: Body = {
    "algorithms": [{"name": "ddpg"}],
    "environments": ["Pendulum"],
    "seeds": 1,
}
"""What stands for a field that is missing or of the wrong form, to look at the others."""


class SubmissionRoute(APIRoute):
    """Where the form of a body is wrong, the parts of it that are right are checked further."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Refuse with what is wrong with the form and with what is wrong beyond it."""
        answer = super().get_route_handler()

        async def answer_or_tell_all(request: Request) -> Response:
            try:
                return await answer(request)
            except RequestValidationError as error:
                told = form_faults(request, error)
                raise InvalidRequest([*told, *_others(error, told)]) from error

        return answer_or_tell_all


def _others(error: RequestValidationError, told: list[Fault]) -> Iterator[Fault]:
    """Yield what is wrong with the parts of a body whose form is right."""
    if not isinstance(error.body, dict):
        return
    body = deepcopy(error.body)
    for each in error.errors():
        if each["loc"][0] == "body":
            _leave_out(body, [part for part in each["loc"][1:] if not str(part).startswith("<")])
    if "environments" not in body:
        for algorithm in body.get("algorithms", ()):
            algorithm.pop("environments", None)
    try:
        request = SweepRequest.model_validate(REQUIRED | body)
    except ValidationError:
        return
    for fault in part_faults(request):
        if not any(_is_within(fault.field, each.field) for each in told):
            yield fault


def _leave_out(body: Body, location: list[str | int]) -> None:
    """Take the field at a location out of a body, or the whole that an algorithm's name stands for.

    Of a list that is wrong in places, all is taken out; an algorithm's place is filled.
    """
    holder: Any = body
    fields: list[tuple[Any, str | int]] = []
    for part in location:
        fields.append((holder, part))
        try:
            holder = holder[part]
        except (KeyError, IndexError, TypeError):  # it is missing, or was taken out
            break
    for holder, part in reversed(fields):
        if part != location[0] and holder is body.get("algorithms"):
            body["algorithms"][part] = dict(REQUIRED["algorithms"][0])
            return
        if isinstance(holder, dict) and (part != "name" or holder is body):
            holder.pop(part, None)
            return


def _is_within(field: str, other: str) -> bool:
    """Whether a field is another, or a part of it, or a whole that it is part of."""
    longer, shorter = sorted((field, other), key=len, reverse=True)
    return longer == shorter or longer.startswith((f"{shorter}.", f"{shorter}["))
