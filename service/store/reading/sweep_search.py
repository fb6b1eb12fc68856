"""The search for sweeps, as conditions on rows of `sweeps`."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from sqlalchemy import ColumnElement, and_, exists, func, not_, or_

from service.model.run import ACTIVE, RunStatus
from service.model.sweep import SweepStatus
from service.store.reading.sweep_names import has
from service.store.tables import is_asking, runs, sweep_names, sweeps

Archived = Literal["false", "true", "all"]


@dataclass(frozen=True)
class SweepSearch:
    """Conditions on listed sweeps; None: no condition.

    q         a text in the name, the notes or a tag, or the beginning of the id; any case
    archived  "false": those that are not, "true": those that are
    only      ids of those that may be found
    """

    q: str | None = None
    tag: str | None = None
    algorithm: str | None = None
    environment: str | None = None
    status: SweepStatus | None = None
    archived: Archived = "all"
    owner: str | None = None
    only: frozenset[str] | None = None

    def conditions(self) -> Iterator[ColumnElement[bool]]:
        """Yield the conditions."""
        if self.q:
            yield _mentions(self.q)
        if self.tag is not None:
            yield has("tag", self.tag)
        if self.algorithm is not None:
            yield has("algorithm", self.algorithm)
        if self.environment is not None:
            yield has("environment", self.environment)
        if self.status is not None:
            yield _stands(self.status)
        if self.owner is not None:
            yield sweeps.c.owner == self.owner
        if self.only is not None:
            yield sweeps.c.id.in_(self.only)
        if self.archived != "all":
            is_archived = sweeps.c.archived_at.is_not(None)
            yield is_archived if self.archived == "true" else not_(is_archived)


EVERY = SweepSearch()


def _mentions(text: str) -> ColumnElement[bool]:
    text = text.lower()

    def holds(column: ColumnElement[str]) -> ColumnElement[bool]:
        return func.lower(column).contains(text, autoescape=True)

    tag = exists().where(
        sweep_names.c.sweep_number == sweeps.c.number,
        sweep_names.c.kind == "tag",
        holds(sweep_names.c.name),
    )
    is_id = sweeps.c.id.startswith(text, autoescape=True)
    return or_(holds(sweeps.c.name), holds(sweeps.c.notes), tag, is_id)


def _stands(status: SweepStatus) -> ColumnElement[bool]:
    """Return the condition of a status, which follows from those of the runs."""
    is_open = func.coalesce(sweeps.c.question, "") == "open"
    is_active = or_(is_asking, *(_some(each) for each in ACTIVE))
    others = or_(_some(RunStatus.QUEUED), _some(RunStatus.RUNNING))
    is_left = and_(_some(RunStatus.PAUSED), not_(others))
    is_paused = and_(is_active, or_(sweeps.c.paused_at.is_not(None), is_left))
    was_cut = and_(sweeps.c.cancelled_at.is_not(None), or_(_some(RunStatus.CANCELLED), is_open))
    has_begun = exists().where(
        runs.c.sweep_number == sweeps.c.number, runs.c.started_at.is_not(None)
    )
    match status:
        case SweepStatus.PAUSED:
            return is_paused
        case SweepStatus.QUEUED:
            return and_(is_active, not_(is_paused), not_(has_begun))
        case SweepStatus.RUNNING:
            return and_(is_active, not_(is_paused), has_begun)
        case SweepStatus.CANCELLED:
            return and_(not_(is_active), was_cut)
        case SweepStatus.FINISHED:
            return and_(not_(is_active), not_(was_cut))


def _some(status: RunStatus) -> ColumnElement[bool]:
    return exists().where(runs.c.sweep_number == sweeps.c.number, runs.c.status == status)
