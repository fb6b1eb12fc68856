"""Errors as problem documents (RFC 9457, `application/problem+json`).

    {"type": "invalid-request", "title": "...", "status": 422, "detail": "...",
     "errors": [{"field": "seeds", "message": "...", "limit": 10000}], "request_id": "..."}

`field` is where in the request (`algorithms[0].weights.w1`), `limit` the bound that was passed,
null where there is none; at most `MAX_FAULTS` are listed. An error inside the server says nothing
of its insides: the log does, under the same request id.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from http import HTTPStatus
from typing import Any, TypeVar

import structlog
from asgi_correlation_id import correlation_id
from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from fastapi_problem.error import (
    ConflictProblem,
    NotFoundProblem,
    Problem,
    StatusProblem,
    UnprocessableProblem,
)
from fastapi_problem.handler import ExceptionHandler, add_exception_handler, new_exception_handler
from sqlalchemy.exc import DBAPIError
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from service.api.shell import address_of, problem_page, wants_page
from service.store.refusal import ImpossibleMoveError
from service.store.upkeep.trouble import AFTERWARDS, Trouble, find_trouble

MEDIA_TYPE = "application/problem+json"
Moved = TypeVar("Moved")
LIMIT_KEYS = ("ge", "gt", "le", "lt", "min_length", "max_length", "multiple_of", "expected")
MAX_FAULTS = 100
MAX_ECHO = 100
LOCATIONS = frozenset({"body", "query", "path", "header", "cookie"})

Handler = Callable[[ExceptionHandler, Request, RequestValidationError], Problem]

log = structlog.get_logger(__name__)


@dataclass(frozen=True)
class Fault:
    """One thing wrong with a request: where, what, and the limit that it passed."""

    field: str
    message: str
    limit: float | str | None = None


class InvalidRequest(UnprocessableProblem):
    """422: the request was understood and cannot be done as it stands."""

    type_ = "invalid-request"
    title = "The request is not valid."

    def __init__(self, faults: Sequence[Fault]) -> None:
        """Refuse for these reasons; there is at least one."""
        self.faults = faults
        shown = [asdict(fault) for fault in faults[:MAX_FAULTS]]
        super().__init__(summary(faults), errors=shown)


class NotFound(NotFoundProblem):
    """404: nothing has that id."""

    type_ = "not-found"
    title = "There is no such thing here."


class ImpossibleMove(ConflictProblem):
    """409: the present state does not allow what was asked."""

    type_ = "impossible-move"
    title = "That cannot be done now."


class ServiceBusy(StatusProblem):
    """503: the service is busy; a later request may succeed."""

    type_ = "busy"
    title = "The service is busy."
    status = 503

    def __init__(self, detail: str) -> None:
        """Refuse for this reason."""
        super().__init__(detail, headers={"Retry-After": "5"})


class DatabaseTrouble(Problem):
    """503: the database cannot do it now, for a reason that passes."""

    def __init__(self, trouble: Trouble) -> None:
        """Say what is wrong and what to do."""
        detail = f"{trouble} {AFTERWARDS}"
        super().__init__(trouble.fact, trouble.name, detail, 503, {"Retry-After": "5"})


class InternalError(StatusProblem):
    """500: our fault."""

    type_ = "internal-error"
    title = "The service failed on this request."

    def __init__(self, detail: str | None = None, **extras: Any) -> None:  # noqa: ARG002
        """`detail`, the exception's own text, stays in the log."""
        super().__init__(
            f"The error is in the service's log under request id {correlation_id.get()}.", **extras
        )


def refusing(move: Callable[[], Moved]) -> Moved:
    """Return what a move returns. Raises ImpossibleMove with the store's reason."""
    try:
        return move()
    except ImpossibleMoveError as refusal:
        text = str(refusal)
        raise ImpossibleMove(f"{text[0].upper()}{text[1:]}.") from refusal


def summary(faults: Sequence[Fault]) -> str:
    """Return the faults as one line."""
    first = f"{faults[0].field}: {faults[0].message}"
    return first if len(faults) == 1 else f"{first} (and {len(faults) - 1} more)"


def faults_of(errors: Sequence[Mapping[str, Any]]) -> list[Fault]:
    """Return pydantic's errors as faults."""
    return [_fault_of(error) for error in errors]


def field_path(location: Sequence[str | int]) -> str:
    """Write a location as one would in Python: `algorithms[0].weights.w1`.

    Tags of unions, written `<tag>`, are no part of it.
    """
    path = ""
    for part in location[1:] if location and location[0] in LOCATIONS else location:
        if isinstance(part, int):
            path += f"[{part}]"
        elif not part.startswith("<"):
            path += f".{printable(part)}" if path else printable(part)
    return path or "body"


def printable(text: str) -> str:
    """Return text that somebody sent, fit to be sent back: short, and valid Unicode."""
    shown = text if len(text) <= MAX_ECHO else f"{text[:MAX_ECHO]}..."
    return shown.encode(errors="backslashreplace").decode()


def problem_response(
    status: HTTPStatus, detail: str, headers: Mapping[str, str] | None = None
) -> Response:
    """Return a problem for those who answer before the application does."""
    document = {
        "type": status.phrase.lower().replace(" ", "-"),
        "title": status.phrase,
        "status": status.value,
        "detail": detail,
        "request_id": correlation_id.get(),
    }
    return JSONResponse(document, status, headers, MEDIA_TYPE)


def install_problem_handlers(app: FastAPI, refuse_invalid: Handler) -> None:
    """Make every error of the application answer with a problem; one of form as is given."""
    handler = new_exception_handler(
        logger=log,
        unhandled_wrappers={"default": InternalError},
        handlers={DBAPIError: _tell_trouble},
        post_hooks=[_add_request_id, _show_to_people],
        request_validation_handler=refuse_invalid,
    )
    add_exception_handler(app, handler)
    app.add_exception_handler(DBAPIError, handler)


def _tell_trouble(_handler: ExceptionHandler, _request: Request, error: DBAPIError) -> Problem:
    trouble = find_trouble(error)
    return InternalError() if trouble is None else DatabaseTrouble(trouble)


def _fault_of(error: Mapping[str, Any]) -> Fault:
    context = error.get("ctx", {})
    if error["type"] == "json_invalid":
        return Fault("body", f"is not JSON at character {error['loc'][-1]}: {context['error']}")
    return Fault(field_path(error["loc"]), _message(error), _limit(context))


def _message(error: Mapping[str, Any]) -> str:
    """Return pydantic's message; messages of our own validators are used as they are."""
    if error["type"] == "value_error":
        return str(error["ctx"]["error"])
    return str(error["msg"])


def _limit(context: Mapping[str, Any]) -> float | str | None:
    for key in LIMIT_KEYS:
        if isinstance(limit := context.get(key), int | float | str):
            return limit
    return None


def _add_request_id(
    document: dict[str, Any], _request: Request, response: JSONResponse
) -> tuple[dict[str, Any], JSONResponse]:
    document["request_id"] = correlation_id.get()
    response.body = json.dumps(document, allow_nan=False).encode()
    return document, response


def _show_to_people(
    document: dict[str, Any], request: Request, response: JSONResponse
) -> tuple[dict[str, Any], Response]:
    """Make a page of it where a person's browser asked for one."""
    if not wants_page(request):
        return document, response
    detail = document.get("detail") or f"{request.url.path}: {document['title']}"
    wanted = address_of(request)
    return document, problem_page(response.status_code, document["title"], detail, wanted)
