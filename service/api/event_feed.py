"""The event log as streams: every change once, in order, to every listener.

While anybody listens, one task reads the log three times a second and keeps the latest events in
memory; each stream takes from there what it has not sent, and from the store what is older. A
stream that reads slowly thus holds nothing back and costs nothing: it has a position, no queue.

Changes that came between two looks are sent together, a run's measurements merged into one
message at the place of the first of them. So a stream that breaks anywhere and resumes after the
last id it saw misses nothing; at worst it hears of some measurements twice.
"""

import asyncio
from collections import deque
from collections.abc import AsyncGenerator, AsyncIterator, Iterable, Iterator, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Any

import structlog
from sqlalchemy.exc import SQLAlchemyError
from starlette.concurrency import run_in_threadpool

from service.model.event import Event
from service.store.store import Store

PERIOD_SECONDS = 0.3
KEPT_EVENTS = 4096
PAGE = 1000
LONGEST_CATCH_UP = 20_000

log = structlog.get_logger(__name__)


@dataclass(frozen=True)
class Message:
    """One message of a stream. kind "reload" says: load everything, what changes later follows."""

    id: int
    kind: str
    payload: Mapping[str, Any]


class EventFeed:
    """Streams of a store's events. Used by one event loop."""

    def __init__(self, store: Store) -> None:
        """Read nothing until somebody listens."""
        self._store = store
        self.listeners = 0
        self._reader: asyncio.Task[None] | None = None
        self._start()

    async def follow(
        self, after: int | None, sweep_id: str | None
    ) -> AsyncGenerator[Message, None]:
        """Yield what happened after an event, of one sweep or of all, for ever.

        Without `after`, or where that is too long ago, the first message is "reload".
        """
        async with self._listening():
            position = self._last if after is None else after
            if after is None or not self._last - LONGEST_CATCH_UP <= after <= self._last:
                position = self._last
                yield Message(position, "reload", {"event_id": position})
            while True:
                news, last = self._news, self._last
                events = await self._after(position, sweep_id)
                for message in coalesce(events):
                    yield message
                if len(events) == PAGE:  # there may be more
                    position = events[-1].id
                else:
                    position = max([position, last, *(event.id for event in events[-1:])])
                    await news.wait()

    async def _after(self, position: int, sweep_id: str | None) -> list[Event]:
        """Return the events after a position, the oldest `PAGE` of them where there are more."""
        if position < self._before_recent:
            return await run_in_threadpool(self._store.events_after, position, sweep_id, PAGE)
        newest_first = takewhile(lambda event: event.id > position, reversed(self._recent))
        return [event for event in newest_first if sweep_id in {None, event.sweep_id}][
            : -PAGE - 1 : -1
        ]

    @asynccontextmanager
    async def _listening(self) -> AsyncIterator[None]:
        """Have the log read while inside."""
        self.listeners += 1
        try:
            if self._reader is None:
                self._start()
                self._reader = asyncio.create_task(self._read())
            await self._found.wait()
            yield
        finally:
            self.listeners -= 1
            if self.listeners == 0 and self._reader is not None:
                self._reader.cancel()
                self._reader = None

    def _start(self) -> None:
        self._recent: deque[Event] = deque(maxlen=KEPT_EVENTS)
        self._before_recent = 0  # the events after this one, up to _last, are in _recent
        self._last = 0
        self._found = asyncio.Event()  # set once the end of the log has been found
        self._news = asyncio.Event()  # set, and replaced, when _last moves

    async def _read(self) -> None:
        """Follow the end of the log. A database that fails is asked again at the next look."""
        while True:
            events: Sequence[Event] = ()
            try:
                if self._found.is_set():
                    events = await run_in_threadpool(self._store.events_after, self._last)
                    self._keep(events)
                else:
                    self._last = await run_in_threadpool(self._store.last_event_id)
                    self._before_recent = self._last
                    self._found.set()
            except SQLAlchemyError:
                log.exception("the event log cannot be read")
            await asyncio.sleep(0.0 if len(events) >= PAGE else PERIOD_SECONDS)

    def _keep(self, events: Sequence[Event]) -> None:
        if not events:
            return
        self._recent.extend(events)
        self._last = events[-1].id
        if len(self._recent) == KEPT_EVENTS:
            self._before_recent = self._recent[0].id - 1
        news, self._news = self._news, asyncio.Event()
        news.set()


def coalesce(events: Iterable[Event]) -> list[Message]:
    """Return events as messages, the measurements of a run merged into the first of them.

    The id of a message says that everything up to it was sent: if an event becomes several
    messages, only the last of them has its id.
    """
    messages: list[Message] = []
    places: dict[str, int] = {}
    for event in events:
        begun = len(messages)
        for payload in _payloads(event):
            place = len(messages)
            if event.kind == "measurements":
                place = places.setdefault(payload["run_id"], place)
            if place == len(messages):
                messages.append(Message(event.id - 1, event.kind, payload))
            else:
                messages[place] = _merged(messages[place], payload)
        if len(messages) > begun:
            messages[-1] = replace(messages[-1], id=event.id)
    return messages


def _payloads(event: Event) -> Iterator[Mapping[str, Any]]:
    """What messages say of an event: of measurements, one for each run."""
    if event.kind != "measurements":
        yield event.payload
        return
    told = event.payload
    for run_id in told["run_ids"]:
        yield {
            "sweep_id": told["sweep_id"],
            "run_id": run_id,
            "from": told["from"],
            "to": told["to"],
        }


def _merged(earlier: Message, later: Mapping[str, Any]) -> Message:
    payload = dict(earlier.payload)
    payload["from"] = min(payload["from"], later["from"])
    payload["to"] = max(payload["to"], later["to"])
    return replace(earlier, payload=payload)
