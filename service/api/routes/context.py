"""What routes are given: store, event feed, dispatcher; the sweep or run of their path.

And the name of the entry that the run is of.
"""

from collections.abc import Mapping
from typing import Annotated, Protocol

from fastapi import Depends, Request
from fastapi import Path as PathParameter

from service.api.event_feed import EventFeed
from service.api.problems import NotFound, printable
from service.api.side_process import Side
from service.model.entry import Entries
from service.model.run import Run
from service.model.sweep import Sweep
from service.store.store import Store
from workers.checkpoints.place import Place

MAX_ID = 64


class Dispatcher(Protocol):
    """What the routes ask of whoever dispatches runs to workers."""

    @property
    def problem(self) -> str | None:
        """Why no run can start now, as a sentence; None while they can."""

    @property
    def workers(self) -> Mapping[str, bool]:
        """The workers that are up, and whether each is busy."""


def _store(request: Request) -> Store:
    store: Store = request.app.state.store
    return store


def _event_feed(request: Request) -> EventFeed:
    feed: EventFeed = request.app.state.event_feed
    return feed


def _dispatcher(request: Request) -> Dispatcher:
    dispatcher: Dispatcher = request.app.state.dispatcher
    return dispatcher


def _checkpoints(request: Request) -> Place:
    checkpoints: Place = request.app.state.checkpoints
    return checkpoints


def _worker_memory(request: Request) -> int:
    worker_memory: int = request.app.state.worker_memory
    return worker_memory


def _side(request: Request) -> Side:
    side: Side = request.app.state.side
    return side


TheCheckpoints = Annotated[Place, Depends(_checkpoints)]
TheSide = Annotated[Side, Depends(_side)]
TheStore = Annotated[Store, Depends(_store)]
TheEventFeed = Annotated[EventFeed, Depends(_event_feed)]
TheWorkerMemory = Annotated[int, Depends(_worker_memory)]
TheDispatcher = Annotated[Dispatcher, Depends(_dispatcher)]


SweepId = Annotated[str, PathParameter(examples=["3f9a0c51b7de"])]
RunId = Annotated[str, PathParameter(examples=["3f9a0c51b7de-17"])]


def _sweep(sweep_id: SweepId, store: TheStore) -> Sweep:
    sweep = store.find_sweep(sweep_id) if may_be_id(sweep_id) else None
    if sweep is None:
        raise NotFound(f"There is no sweep {printable(sweep_id)!r}.")
    return sweep


def _run(run_id: RunId, store: TheStore) -> Run:
    return find_run(run_id, store)


def find_run(run_id: str, store: Store) -> Run:
    """Return the run of that id. Raises NotFound."""
    run = store.find_run(run_id) if may_be_id(run_id) else None
    if run is None:
        raise NotFound(f"There is no run {printable(run_id)!r}.")
    return run


def may_be_id(text: str) -> bool:
    """Whether it is worth asking the database, which may choke on what no id holds."""
    return len(text) <= MAX_ID and text.isascii() and text.isprintable()


TheSweep = Annotated[Sweep, Depends(_sweep)]
TheRun = Annotated[Run, Depends(_run)]


def _label(run: TheRun, store: TheStore) -> str:
    return Entries(store.sweep_request(run.sweep_id)).label(run.id)


TheLabel = Annotated[str, Depends(_label)]
