"""A limit on the size of a request's body, as a pure ASGI middleware."""

from http import HTTPStatus

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.refusals.problems import problem_response

MAX_BODY_BYTES = 2**20
MAX_LENGTH_DIGITS = 20


class BodyLimit:
    """Refuses a body above `MAX_BODY_BYTES`, by its announced length or as it streams in."""

    def __init__(self, app: ASGIApp) -> None:
        """Guard `app`."""
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer 413 at once where the announced length is too large."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
        elif _announced_length(scope) > MAX_BODY_BYTES:
            refusal = problem_response(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, _refusal())
            await refusal(scope, receive, send)
        else:
            await self.app(scope, _counting(receive), send)


def _announced_length(scope: Scope) -> int:
    length = Headers(scope=scope).get("content-length", "")
    is_number = length.isascii() and length.isdigit()
    return int(length[:MAX_LENGTH_DIGITS]) if is_number else 0


def _counting(receive: Receive) -> Receive:
    received = 0

    async def receive_within_limit() -> Message:
        nonlocal received
        message = await receive()
        received += len(message.get("body", b""))
        if received > MAX_BODY_BYTES:
            raise HTTPException(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, _refusal())
        return message

    return receive_within_limit


def _refusal() -> str:
    return f"The body is larger than the limit of {MAX_BODY_BYTES} bytes."
