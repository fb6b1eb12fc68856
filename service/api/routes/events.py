"""Changes as they happen: server-sent events, resumable."""

import json
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing
from typing import Annotated, Any

from fastapi import APIRouter, Header, Query
from sse_starlette import EventSourceResponse, ServerSentEvent

from service.api.access.authority import MAY_READ, MAY_SEE_SHARED
from service.api.access.register import Register
from service.api.context import TheCaller, TheEventFeed, TheRegister, TheSweep
from service.api.event_feed import Message
from service.model.caller import Caller

router = APIRouter(tags=["events"])

PING_SECONDS = 15
SEND_TIMEOUT_SECONDS = 20.0
RETRY_MILLISECONDS = 1000
MAX_EVENT_ID = 2**63 - 1

EventId = Annotated[int | None, Query(ge=0, le=MAX_EVENT_ID)]
LastEventId = Annotated[str | None, Header(alias="Last-Event-ID", max_length=20)]
STREAM: dict[int | str, dict[str, Any]] = {
    200: {
        "description": (
            "`sweep`, `run`, `measurements`, `diagnosis` and `log` messages: what changed, as JSON "
            "with the sweep's id; `reload`: load everything, changes after this message follow."
        ),
        "content": {
            "text/event-stream": {
                "example": (
                    "id: 17\nevent: measurements\n"
                    'data: {"sweep_id":"3f9a0c51b7de","run_id":"3f9a0c51b7de-3",'
                    '"from":800,"to":2400}\n\n'
                )
            }
        },
    }
}


@router.get(
    "/events",
    response_class=EventSourceResponse,
    responses=STREAM,
    dependencies=[MAY_SEE_SHARED],
)
def stream_events(
    caller: TheCaller,
    register: TheRegister,
    feed: TheEventFeed,
    last_event_id: LastEventId = None,
    after: EventId = None,
) -> EventSourceResponse:
    """Stream the changes of every sweep, from the one after `Last-Event-ID` (or `after`)."""
    messages = feed.follow(_position(last_event_id, after), None)
    return _stream(_for_caller(messages, caller, register))


@router.get(
    "/sweeps/{sweep_id}/events",
    response_class=EventSourceResponse,
    responses=STREAM,
    dependencies=[MAY_READ],
)
def stream_sweep_events(
    sweep: TheSweep,
    caller: TheCaller,
    register: TheRegister,
    feed: TheEventFeed,
    last_event_id: LastEventId = None,
    after: EventId = None,
) -> EventSourceResponse:
    """Stream the changes of one sweep, from the one after `Last-Event-ID` (or `after`)."""
    messages = feed.follow(_position(last_event_id, after), sweep.id)
    return _stream(_for_caller(messages, caller, register))


def _position(last_event_id: str | None, after: int | None) -> int | None:
    """Return where to go on. A browser that reconnects knows better than its first URL."""
    if last_event_id is None:
        return after
    is_id = last_event_id.isascii() and last_event_id.isdigit()
    return int(last_event_id) if is_id and int(last_event_id) <= MAX_EVENT_ID else None


async def _for_caller(
    messages: AsyncGenerator[Message, None], caller: Caller, register: Register
) -> AsyncIterator[Message]:
    """Yield what a caller may see, for as long as it would be let in."""
    async with aclosing(messages):
        async for message in messages:
            if not register.holds(caller):
                return
            if message.kind == "reload" or caller.sees(message.payload["sweep_id"]):
                yield message


def _stream(messages: AsyncIterator[Message]) -> EventSourceResponse:
    return EventSourceResponse(
        _encoded(messages), ping=PING_SECONDS, send_timeout=SEND_TIMEOUT_SECONDS
    )


async def _encoded(messages: AsyncIterator[Message]) -> AsyncIterator[ServerSentEvent]:
    yield ServerSentEvent(retry=RETRY_MILLISECONDS)
    async for message in messages:
        yield ServerSentEvent(
            json.dumps(message.payload, allow_nan=False, separators=(",", ":")),
            id=str(message.id),
            event=message.kind,
        )
