"""Pages of a list: keyset pagination with an opaque cursor."""

import base64
from collections.abc import Sequence
from typing import Generic, TypeVar

from fastapi import Request, Response
from pydantic import BaseModel, ConfigDict, Field

from service.api.place import here
from service.api.refusals.problems import Fault, InvalidRequest

Item = TypeVar("Item", bound=BaseModel)
DEFAULT_LIMIT = 100
MAX_LIMIT = 1000


class Page(BaseModel, Generic[Item]):
    """Some items of a list, and where to go on."""

    items: list[Item]
    next: str | None = Field(description="Cursor for `after`; null on the last page.")


class PageQuery(BaseModel):
    """Which items of a list."""

    model_config = ConfigDict(extra="forbid")

    limit: int = Field(default=DEFAULT_LIMIT, ge=1, le=MAX_LIMIT)
    after: str | None = Field(
        default=None, max_length=200, description="`next` of the previous page."
    )


def read_cursor(cursor: str | None) -> str | None:
    """Return the id in a cursor. Raises InvalidRequest for anything else."""
    if cursor is None:
        return None
    try:
        return base64.b64decode(cursor, altchars=b"-_", validate=True).decode("ascii")
    except ValueError as error:  # of which binascii.Error is one
        fault = Fault("after", "is not a cursor: use `next` of the previous page, unchanged")
        raise InvalidRequest([fault]) from error


def page_of(items: Sequence[Item], limit: int, request: Request, response: Response) -> Page[Item]:
    """Return the page of `limit + 1` items from the store: the last one means a next page.

    Items have an `id`. The Link header (RFC 8288) says where the next page is.
    """
    if len(items) <= limit:
        return Page(items=list(items), next=None)
    shown = list(items[:limit])
    cursor = base64.urlsafe_b64encode(str(shown[-1].id).encode()).decode()  # type: ignore[attr-defined]
    url = request.url.include_query_params(after=cursor)
    response.headers["Link"] = f'<{here(url.path)}?{url.query}>; rel="next"'
    return Page(items=shown, next=cursor)
