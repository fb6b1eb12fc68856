"""What can be wrong with an addition to a sweep."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from algorithms import catalogue
from service.api.refusals.problems import Fault, ImpossibleMove, InvalidRequest
from service.api.schemas.requests.growth import GrowthRequest
from service.api.schemas.requests.sweep_request import MAX_RUNS, SweepRequest
from service.api.submission.memory import memory_faults
from service.api.submission.plan import plan
from service.model.request.entry import Entries, Json
from service.model.request.growth import seeds_of, with_algorithms
from service.model.request.plan import Plan
from service.model.sweep import Sweep
from service.store.claiming.growth import Cell


def growth_plan(
    sweep: Sweep, cells: Sequence[Cell], request: GrowthRequest, worker_memory: int
) -> Plan:
    """Return the plan of an addition; for an extension, of the timesteps that are added.

    Raises InvalidRequest, ImpossibleMove.
    """
    if request.seeds is not None:
        check_seeds(sweep, cells, request.seeds)
        return _plan_of(sweep, cells, request.seeds)
    if request.timesteps is not None:
        check_timesteps(sweep, cells, request.timesteps, worker_memory)
        more = [_lengthened(cell, request.timesteps) for cell in cells]
        return _plan_of(sweep, more, seeds_of(sweep.request))
    return plan_entries(sweep, posted_algorithms(request), worker_memory)


def posted_algorithms(request: GrowthRequest) -> list[Json]:
    """Return the algorithms of an addition as they were posted."""
    posted: list[Json] = request.model_dump(mode="json", exclude_unset=True)["algorithms"]
    return posted


def _plan_of(sweep: Sweep, cells: Sequence[Cell], seeds: Sequence[int]) -> Plan:
    entries = Entries(sweep.request).all
    return Plan(
        cells=tuple(replace(cell.spec, seed=seeds[0]) for cell in cells),
        entries=tuple(entries[cell.entry] for cell in cells),
        seeds=seeds,
        notices=(),
    )


def _lengthened(cell: Cell, timesteps: int) -> Cell:
    """The cell with only the timesteps that it lacks."""
    spec = replace(cell.spec, timesteps=timesteps - cell.spec.timesteps)
    return cell._replace(spec=spec)


def check_seeds(sweep: Sweep, cells: Sequence[Cell], seeds: Sequence[int]) -> None:
    """Raise InvalidRequest for seeds that a sweep has, or that make it too large."""
    own = set(seeds_of(sweep.request))
    faults = [
        Fault(f"seeds[{i}]", f"{seed} is one of its seeds already, or is repeated")
        for i, seed in enumerate(seeds)
        if seed in own or seed in seeds[:i]
    ]
    total = sweep.runs.total + len(cells) * len(seeds)
    if total > MAX_RUNS:
        faults.append(Fault("seeds", f"{total} runs; a sweep has at most {MAX_RUNS}", MAX_RUNS))
    if faults:
        raise InvalidRequest(faults)


def plan_entries(sweep: Sweep, algorithms: Sequence[Json], worker_memory: int) -> Plan:
    """Return the plan of the new entries alone. Raises InvalidRequest."""
    first_item, first_place = len(sweep.request["algorithms"]), len(Entries(sweep.request).all)
    posted = {name: value for name, value in sweep.request.items() if name != "search"}
    merged = SweepRequest.model_validate(with_algorithms(posted, algorithms))
    try:
        whole = plan(merged, worker_memory)
    except InvalidRequest as refusal:
        faults = [replace(each, field=_shifted(each.field, first_item)) for each in refusal.faults]
        raise InvalidRequest(faults) from refusal
    new = [
        (cell, entry)
        for cell, entry in zip(whole.cells, whole.entries, strict=True)
        if entry.place >= first_place
    ]
    return replace(
        whole, cells=tuple(cell for cell, _ in new), entries=tuple(entry for _, entry in new)
    )


def _shifted(field: str, first: int) -> str:
    """Return a field of the whole request as one of the addition: `algorithms[3]` is the first."""
    if not (found := re.match(r"algorithms\[(\d+)\]", field)):
        return field
    item = int(found[1]) - first
    return f"algorithms[{item}]{field[found.end() :]}" if item >= 0 else f"sweep.{field}"


def check_timesteps(
    sweep: Sweep, cells: Sequence[Cell], timesteps: int, worker_memory: int
) -> None:
    """Raise InvalidRequest for timesteps that are no more, ImpossibleMove for what cannot go on."""
    _refuse_what_starts_anew(cells)
    if isinstance(sweep.request.get("scale"), list):
        raise ImpossibleMove(
            "A sweep whose entries differ in their share of the timesteps (scale) cannot be "
            "extended: submit it again with more timesteps."
        )
    faults = list(_short(cells, timesteps))
    entries = Entries(sweep.request).all
    longer = [(entries[cell.entry], replace(cell.spec, timesteps=timesteps)) for cell in cells]
    faults = faults or list(memory_faults(longer, worker_memory))
    if faults:
        raise InvalidRequest(faults)


def _refuse_what_starts_anew(cells: Sequence[Cell]) -> None:
    names = dict.fromkeys(cell.spec.algorithm for cell in cells)
    known = {name: catalogue.known(name) for name in names}
    stuck = [name for name, each in known.items() if each is None or not each.can_go_on]
    if stuck:
        raise ImpossibleMove(
            f"Runs of {', '.join(stuck)} cannot go on from where they ended: what they do depends "
            "on their number of timesteps. Submit them again with more timesteps."
        )


def _short(cells: Sequence[Cell], timesteps: int) -> Iterator[Fault]:
    if all(cell.spec.timesteps == timesteps for cell in cells):
        return  # it was asked for before
    most = max(cells, key=lambda cell: cell.spec.timesteps).spec
    if timesteps <= most.timesteps:
        message = f"must be more than the {most.timesteps} of its runs in {most.environment}"
        yield Fault("timesteps", message, most.timesteps)
