"""Diagnoses of where the simulator's gradients help: requested, answered and drawn."""

from collections.abc import Sequence
from http import HTTPStatus
from typing import Annotated, Any

from fastapi import APIRouter, Query, Response

from service.analysis.diagnosis import FIGURES, FigureName, diagnosed_cells, figures_of
from service.analysis.figures.figure_form import MEDIA_TYPES, Form
from service.api.access.authority import MAY_READ, MAY_SUBMIT
from service.api.context import (
    TheLabel,
    TheRun,
    TheSide,
    TheStore,
    TheSweep,
    held,
)
from service.api.diagnoser import Diagnoser
from service.api.learned import Learned, TheLearned
from service.api.load.side_process import BusyError, Side, TooSlowError
from service.api.place import here
from service.api.refusals.nearest import unknown_name
from service.api.refusals.problems import (
    Fault,
    ImpossibleMove,
    InvalidRequest,
    NotFound,
    ServiceBusy,
)
from service.api.revalidation import REVALIDATED, RevalidatedRoute
from service.api.schemas.diagnosis_answer import CellsQuery, DiagnosisAnswer
from service.model.diagnosis import Diagnosis
from service.model.request.entry import Entries, Entry
from service.model.run import Run
from service.model.sweep import Sweep
from service.store.refusal import TooManyAskedError
from service.store.store import Store

router = APIRouter()
runs = APIRouter(prefix="/runs/{run_id}/diagnosis", tags=["runs"])
sweeps = APIRouter(prefix="/sweeps/{sweep_id}/diagnosis", tags=["sweeps"])
told = APIRouter(
    prefix="/sweeps/{sweep_id}/diagnosis",
    tags=["sweeps"],
    route_class=RevalidatedRoute,
    dependencies=[MAY_READ, *REVALIDATED],
)

MOST_AT_ONCE = 256
TheDiagnoser = Annotated[Diagnoser, held("diagnoser")]
Cells = Annotated[CellsQuery, Query()]
PICTURES: dict[int | str, dict[str, Any]] = {
    200: {"content": {each: {} for each in MEDIA_TYPES.values()}}
}


@runs.post("", status_code=HTTPStatus.ACCEPTED, dependencies=[MAY_SUBMIT])
def diagnose_run(
    run: TheRun,
    label: TheLabel,
    store: TheStore,
    learned: TheLearned,
    diagnoser: TheDiagnoser,
) -> DiagnosisAnswer:
    """Request the diagnosis of a run that has ended, from what it has learned.

    It takes some seconds and is made once. A repeated request answers the same diagnosis; one that
    failed is tried again.
    """
    _refuse_undiagnosable(run, learned)
    _ask(diagnoser, [run])
    return _of_run(store, run, label)


@runs.get("", dependencies=[MAY_READ])
def get_run_diagnosis(run: TheRun, label: TheLabel, store: TheStore) -> DiagnosisAnswer:
    """Answer the diagnosis of a run, or its progress."""
    return _of_run(store, run, label)


@runs.get(
    "/{figure}.{form}",
    response_class=Response,
    responses=PICTURES,
    dependencies=[MAY_READ],
)
def get_run_diagnosis_figure(
    run: TheRun, figure: FigureName, form: Form, store: TheStore, side: TheSide
) -> Response:
    """Draw a figure of the diagnosis of a run."""
    entries = Entries(store.sweep_request(run.sweep_id))
    diagnoses = [store.find_diagnosis(run.id)]
    subject = f"{entries.label(run)}, seed {run.spec.seed} ({run.id})"
    return _drawn(side, figure, subject, diagnoses, entries, form)


@sweeps.post("", status_code=HTTPStatus.ACCEPTED, dependencies=[MAY_SUBMIT])
def diagnose_sweep(
    sweep: TheSweep, cells: Cells, store: TheStore, diagnoser: TheDiagnoser
) -> DiagnosisAnswer:
    """Request the diagnoses of the first runs of each cell that reached their end.

    Each takes some seconds and is made once, one after the other. Those that failed are tried
    again.
    """
    diagnoses = _of_cells(store, sweep, cells)
    if not diagnoses:
        raise ImpossibleMove(
            f"No run of sweep {sweep.id} has reached its end, and only such runs can be diagnosed."
        )
    if len(diagnoses) > MOST_AT_ONCE:
        reason = (
            f"would be {len(diagnoses)} diagnoses; at most {MOST_AT_ONCE} are possible at once: "
            "ask for fewer seeds, or for one environment at a time"
        )
        raise InvalidRequest([Fault("seeds", reason, MOST_AT_ONCE)])
    _ask(diagnoser, [each.run for each in diagnoses])
    return _of_sweep(store, sweep, cells)


@told.get("")
def get_sweep_diagnosis(sweep: TheSweep, cells: Cells, store: TheStore) -> DiagnosisAnswer:
    """Answer the diagnoses of the runs of a sweep, as medians over the seeds of each cell."""
    return _of_sweep(store, sweep, cells)


@told.get("/{figure}.{form}", response_class=Response, responses=PICTURES)
def get_sweep_diagnosis_figure(
    sweep: TheSweep,
    figure: FigureName,
    form: Form,
    cells: Cells,
    store: TheStore,
    side: TheSide,
) -> Response:
    """Draw a figure of the diagnoses of the runs of a sweep: a column a task."""
    diagnoses = _of_cells(store, sweep, cells)
    subject = f"{sweep.name} ({sweep.id})"
    return _drawn(side, figure, subject, diagnoses, Entries(sweep.request), form)


router.include_router(runs)
router.include_router(sweeps)
router.include_router(told)


def _refuse_undiagnosable(run: Run, learned: Learned) -> None:
    """Raise ImpossibleMove or ServiceBusy, with the reason why a run cannot be diagnosed."""
    if not run.status.is_final:
        raise ImpossibleMove(f"Run {run.id} is {run.status}: only ended runs can be diagnosed.")
    learned.refuse_missing(run)


def _ask(diagnoser: Diagnoser, asked: Sequence[Run]) -> None:
    try:
        diagnoser.ask(asked)
    except TooManyAskedError as refusal:
        raise ServiceBusy(f"{refusal}: ask again when some are made.") from refusal


def _of_run(store: Store, run: Run, label: str) -> DiagnosisAnswer:
    diagnoses = [store.find_diagnosis(run.id)] if run.status.is_final else []
    link = here(f"/api/v1/runs/{run.id}/diagnosis")
    return DiagnosisAnswer.of(link, diagnoses, lambda _: label)


def _of_sweep(store: Store, sweep: Sweep, cells: CellsQuery) -> DiagnosisAnswer:
    diagnoses = _of_cells(store, sweep, cells)
    link = here(f"/api/v1/sweeps/{sweep.id}/diagnosis")
    return DiagnosisAnswer.of(link, diagnoses, Entries(sweep.request).label)


def _of_cells(store: Store, sweep: Sweep, cells: CellsQuery) -> list[Diagnosis]:
    """The diagnoses of the asked runs. Raises InvalidRequest for a task that is not the sweep's."""
    entries = Entries(sweep.request)
    environments = list(dict.fromkeys(environment for environment, _ in entries.cells))
    if cells.environment is not None and cells.environment not in environments:
        raise InvalidRequest([unknown_name("environment", cells.environment, environments)])
    return store.list_diagnoses(sweep.id, most_of_cell=cells.seeds, environment=cells.environment)


def _drawn(
    side: Side,
    figure: FigureName,
    subject: str,
    diagnoses: Sequence[Diagnosis],
    entries: Entries,
    form: Form,
) -> Response:
    """Draw a figure. Raises NotFound if there is nothing to show, and ServiceBusy."""
    cells = diagnosed_cells(diagnoses, entries.label)
    if figure not in figures_of(cells):
        raise NotFound(_nothing_of(figure, bool(cells)))
    everyone: tuple[Entry, ...] = tuple(entries.all)
    draw = "service.analysis.figures.diagnosis_figure:draw"
    try:
        picture = side.call(draw, figure, subject, cells, everyone, form)
    except (BusyError, TooSlowError, EOFError) as error:
        raise ServiceBusy(f"The figure could not be drawn: {error}.") from error
    return Response(picture, media_type=MEDIA_TYPES[form])


def _nothing_of(figure: FigureName, is_diagnosed: bool) -> str:
    """Why there is no figure."""
    if is_diagnosed:
        return f"Nothing to draw for {FIGURES[figure].title!r}: these runs have no critic."
    return "There is no diagnosis yet: request one by POST to this address without the figure."
