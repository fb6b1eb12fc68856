"""Sweeps: listing them, looking at one, describing it."""

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from pydantic import Field

from service.api.access.authority import MAY_READ, MAY_SEE_SHARED, MAY_SUBMIT
from service.api.context import TheCaller, TheStore, TheSweep, TheWebhookHosts
from service.api.revalidation import TaggedRoute
from service.api.schemas.listed_sweep_answer import SPARKLINE_POINTS, ListedSweepAnswer
from service.api.schemas.page import Page, PageQuery, page_of, read_cursor
from service.api.schemas.requests.sweep_edit import OneTag, SweepEdit
from service.api.schemas.requests.texts import MAX_NAME, Name, Text
from service.api.schemas.sweep_answer import SweepAnswer
from service.api.submission.webhook import refuse_webhook
from service.model.environment import best_return
from service.model.standing import best_of
from service.model.sweep import SweepStatus
from service.store.reading.sweep_search import Archived, SweepSearch

router = APIRouter(prefix="/sweeps", tags=["sweeps"], route_class=TaggedRoute)


class SweepQuery(PageQuery):
    """Which sweeps."""

    q: Text | None = Field(
        default=None,
        max_length=MAX_NAME,
        description="A text in the name, the notes or a tag, or the beginning of the id.",
    )
    tag: OneTag | None = None
    algorithm: Name | None = None
    environment: Name | None = None
    status: SweepStatus | None = None
    archived: Archived = "false"
    owner: Name | None = Field(default=None, description="Who submitted it.")

    def search(self, only: frozenset[str] | None) -> SweepSearch:
        """The search of the store, among the sweeps that the caller may see; None: all."""
        return SweepSearch(
            self.q,
            self.tag,
            self.algorithm,
            self.environment,
            self.status,
            self.archived,
            self.owner,
            only,
        )


@router.get("", dependencies=[MAY_SEE_SHARED])
def list_sweeps(
    query: Annotated[SweepQuery, Query()],
    request: Request,
    response: Response,
    caller: TheCaller,
    store: TheStore,
) -> Page[ListedSweepAnswer]:
    """List sweeps, newest first; archived ones only on request."""
    search = query.search(caller.sweeps)
    sweeps = store.list_sweeps(read_cursor(query.after), query.limit + 1, search)
    cells = store.sweep_standings([sweep.id for sweep in sweeps[: query.limit]])
    best = best_of(cells, store.random_returns(), best_return)
    outlines = store.sweep_outlines([each.cell for each in best.values()], SPARKLINE_POINTS)
    answers = [
        ListedSweepAnswer.of(sweep, best.get(sweep.id), outlines.get(sweep.id, ()))
        for sweep in sweeps
    ]
    return page_of(answers, query.limit, request, response)


@router.patch("/{sweep_id}", dependencies=[MAY_SUBMIT])
def edit_sweep(
    sweep: TheSweep, edit: SweepEdit, store: TheStore, webhook_hosts: TheWebhookHosts
) -> SweepAnswer:
    """Change the description, priority, limits or webhook of a sweep, at any time."""
    refuse_webhook(edit.webhook, webhook_hosts)
    return SweepAnswer.of(store.edit_sweep(sweep.id, edit.changes))


@router.get("/{sweep_id}", dependencies=[MAY_READ])
def get_sweep(sweep: TheSweep) -> SweepAnswer:
    """Show a sweep: its status, counts of runs, progress."""
    return SweepAnswer.of(sweep)
