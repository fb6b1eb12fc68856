"""From a posted sweep to its plan, or to all that is wrong with it."""

from collections.abc import Sequence

from algorithms.measurement import MEASURE_EVERY
from algorithms.presets import completed, preset
from service.api.refusals.problems import Fault, InvalidRequest
from service.api.schemas.requests.sweep_request import SweepRequest
from service.api.submission.check import cap_faults, label_faults, name_faults, product_faults
from service.api.submission.grid_faults import zip_faults
from service.api.submission.memory import memory_faults
from service.api.submission.question_faults import question_faults, question_notices
from service.api.submission.same_curve import notices, repetition_faults
from service.api.submission.search_plan import (
    first_rung,
    planned_search,
    search_faults,
    search_notices,
)
from service.model.inquiry.question import Question
from service.model.request.entry import Entries, Entry, Json
from service.model.request.plan import Plan
from workers.messages.run_spec import RunSpec, Weights


def plan(request: SweepRequest, worker_memory: int) -> Plan:
    """Return the plan of a sweep.

    Raises InvalidRequest with everything that is wrong: first for a product above the cap, which
    is counted and not expanded, then for what its parts and its cells ask, then for runs that would
    fill more than the worker's memory.
    """
    posted = request.model_dump(mode="json", exclude_unset=True)
    _refuse(_grid_faults(request, posted))
    question = Question.of(posted)
    seeds: Sequence[int] = (
        range(request.seeds) if isinstance(request.seeds, int) else tuple(request.seeds)
    )
    entries = Entries(posted)
    cells = [
        (entry, _spec(entry, environment, request, seeds[0]))
        for environment, entry in entries.cells
    ]
    _refuse(
        [
            *name_faults(request),
            *product_faults(request, posted, entries.all),
            *repetition_faults(cells),
            *label_faults(request, entries.all),
            *question_faults(question, entries),
            *search_faults(request, cells),
        ]
    )
    _refuse(list(memory_faults(cells, worker_memory)))
    search = planned_search(request, cells)
    return Plan(
        cells=tuple(spec for _, spec in first_rung(cells, search)),
        entries=tuple(entry for entry, _ in cells),
        seeds=seeds if search is None else search.seeds,
        notices=(
            *notices(cells),
            *question_notices(question, entries),
            *search_notices(search),
        ),
        search=search,
    )


def part_faults(request: SweepRequest) -> list[Fault]:
    """Return what is wrong with the parts of a sweep, each looked at by itself."""
    posted = request.model_dump(mode="json", exclude_unset=True)
    return _grid_faults(request, posted) or [
        *name_faults(request),
        *product_faults(request, posted, Entries(posted).all),
    ]


def _grid_faults(request: SweepRequest, posted: Json) -> list[Fault]:
    """Return why a sweep's grids cannot be expanded, and what else is seen without doing so."""
    if unlike := list(zip_faults(posted)):
        return [*unlike, *name_faults(request)]
    return cap_faults(request, posted)


def _refuse(faults: Sequence[Fault]) -> None:
    if faults:
        raise InvalidRequest(faults)


def _spec(entry: Entry, environment: str, request: SweepRequest, seed: int) -> RunSpec:
    """Return the entry's cell in one environment; what it does not state is the preset's."""
    usual = preset(entry.algorithm, environment)
    return RunSpec(
        algorithm=entry.algorithm,
        environment=environment,
        seed=seed,
        weights=Weights(*usual.weights) if entry.weights is None else entry.weights,
        timesteps=_scaled(request.timesteps or usual.timesteps, entry.scale or 1.0),
        config=completed(entry.algorithm, environment, entry.config),
    )


def _scaled(timesteps: int, scale: float) -> int:
    """Return that share of the timesteps, in whole measurements."""
    if scale == 1.0:
        return timesteps
    return max(round(scale * timesteps / MEASURE_EVERY), 1) * MEASURE_EVERY
