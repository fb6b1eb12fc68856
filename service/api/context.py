"""What routes depend on: parts of the application, and the sweep or run in their path."""

from collections.abc import Mapping
from typing import Annotated, Any, Protocol

from anyio import from_thread
from fastapi import Depends, Request
from fastapi import Path as PathParameter

from service.api.access.register import Register
from service.api.event_feed import EventFeed
from service.api.load.side_process import Side, SideProcess
from service.api.refusals.problems import Fault, InvalidRequest, NotFound, printable
from service.model.caller import Caller
from service.model.compared import SEPARATOR, Compared
from service.model.request.entry import Entries
from service.model.run import Run
from service.model.sweep import Sweep
from service.store.store import Store
from service.task_shelf import TaskShelf
from workers.checkpoints.place import Place

MAX_ID = 64
MAX_COMPARED = 20


class Workforce(Protocol):
    """What the routes ask of the dispatcher of runs."""

    @property
    def problem(self) -> str | None:
        """Why no run can start now, as a sentence; None while they can."""

    @property
    def workers(self) -> Mapping[str, bool]:
        """The workers that are up, and whether each is busy."""


class RequestedSide:
    """The side process, for one request: a call whose client has gone is not begun."""

    def __init__(self, side: SideProcess, request: Request) -> None:
        """Call nothing yet; calls come from a thread of the event loop's."""
        self._side = side
        self._request = request

    def call(self, function: str, *arguments: Any) -> Any:
        """Return what the function returns, raise what it raises; or BusyError, TooSlowError."""
        return self._side.call(function, *arguments, is_wanted=self._is_wanted)

    def _is_wanted(self) -> bool:
        return not from_thread.run(self._request.is_disconnected)


def held(name: str) -> Any:
    """Return the dependency on what the application holds under a name."""

    def of_application(request: Request) -> Any:
        return getattr(request.app.state, name)

    return Depends(of_application)


TheCheckpoints = Annotated[Place, held("checkpoints")]
TheShelf = Annotated[TaskShelf, held("shelf")]
TheRegister = Annotated[Register, held("register")]
TheStore = Annotated[Store, held("store")]
TheEventFeed = Annotated[EventFeed, held("event_feed")]
TheWorkerMemory = Annotated[int, held("worker_memory")]
TheWebhookHosts = Annotated[tuple[str, ...], held("webhook_hosts")]
TheWorkforce = Annotated[Workforce, held("dispatcher")]


def _side(request: Request) -> Side:
    return RequestedSide(request.app.state.side, request)


TheSide = Annotated[Side, Depends(_side)]


SweepId = Annotated[str, PathParameter(examples=["3f9a0c51b7de"])]
SweepIds = Annotated[
    str,
    PathParameter(
        examples=["3f9a0c51b7de"],
        description="Id of a sweep; or ids of several, joined by `+`, which are compared as one.",
    ),
]
RunId = Annotated[str, PathParameter(examples=["3f9a0c51b7de-17"])]


def _sweep(sweep_id: SweepId, store: TheStore) -> Sweep:
    sweep = store.find_sweep(sweep_id) if may_be_id(sweep_id) else None
    if sweep is None:
        raise NotFound(f"There is no sweep {printable(sweep_id)!r}.")
    return sweep


def _compared(sweep_id: SweepIds, store: TheStore) -> Compared:
    ids = list(dict.fromkeys(sweep_id.split(SEPARATOR)))
    if len(ids) > MAX_COMPARED:
        reason = f"names {len(ids)} sweeps; at most {MAX_COMPARED} can be compared"
        raise InvalidRequest([Fault("sweep_id", reason, MAX_COMPARED)])
    return Compared([_sweep(each, store) for each in ids])


def _run(run_id: RunId, store: TheStore) -> Run:
    return find_run(run_id, store)


def find_run(run_id: str, store: Store) -> Run:
    """Return the run of that id. Raises NotFound."""
    run = store.find_run(run_id) if may_be_id(run_id) else None
    if run is None:
        raise NotFound(f"There is no run {printable(run_id)!r}.")
    return run


def may_be_id(text: str) -> bool:
    """Whether a text can be an id; the database may fail on other characters."""
    return len(text) <= MAX_ID and text.isascii() and text.isprintable()


def _caller(request: Request) -> Caller:
    caller: Caller = request.state.caller
    return caller


TheCaller = Annotated[Caller, Depends(_caller)]
TheSweep = Annotated[Sweep, Depends(_sweep)]
TheCompared = Annotated[Compared, Depends(_compared)]
TheRun = Annotated[Run, Depends(_run)]


def _label(run: TheRun, store: TheStore) -> str:
    return Entries(store.sweep_request(run.sweep_id)).label(run)


TheLabel = Annotated[str, Depends(_label)]
