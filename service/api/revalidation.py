"""Answers that a client may keep and asks about again: an ETag, and 304 while nothing changed.

(Every answer says `Cache-Control: private, no-cache`: keep it, and ask before each use.)

The tag goes by the sweep's newest event (every change has one), the newest random return (the zero
of the normalised scale), the question, and this process: another version of the program may draw
the same data differently. It is read before the answer is made, so an answer can be newer than its
tag says and is then fetched once too often, never once too rarely.

These are the answers that are made of all that a sweep has measured, so they have a budget
(`service/api/load/read_budget.py`).
"""

import hashlib
import secrets
from collections.abc import Callable, Coroutine
from typing import Any

from fastapi import Request, Response
from fastapi.routing import APIRoute
from starlette.concurrency import run_in_threadpool

from service.api.context import may_be_id
from service.store.store import Store

PROCESS = secrets.token_hex(8)


class RevalidatedRoute(APIRoute):
    """A route under `/sweeps/{sweep_id}` whose answers depend on that sweep alone."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Answer 304 where the client has the present answer, else tag the new one."""
        answer = super().get_route_handler()

        async def revalidate(request: Request) -> Response:
            tag = await run_in_threadpool(entity_tag, request)
            if tag is None:
                return await answer(request)
            headers = {"ETag": tag}
            if tag in known_tags(request.headers.get("if-none-match", "")):
                return Response(status_code=304, headers=headers)
            points = await run_in_threadpool(points_of, request)
            async with request.app.state.read_budget.of(points):
                response = await answer(request)
            if response.status_code == 200:
                response.headers.update(headers)
            return response

        return revalidate


def entity_tag(request: Request) -> str | None:
    """Return the weak tag of the present answer; None where there is no such sweep."""
    store: Store = request.app.state.store
    sweep_id = request.path_params["sweep_id"]
    version = store.sweep_version(sweep_id) if may_be_id(sweep_id) else None
    if version is None:
        return None
    question = (request.url.path, request.url.query, request.headers.get("accept", ""))
    digest = hashlib.sha256(repr((PROCESS, version, question)).encode()).hexdigest()
    return f'W/"{digest[:32]}"'


def points_of(request: Request) -> int:
    """Return about how many measurements the sweep has."""
    store: Store = request.app.state.store
    return store.count_points(request.path_params["sweep_id"])


def known_tags(header: str) -> set[str]:
    """Read `If-None-Match`; a strong tag counts as its weak one."""
    tags = (tag.strip() for tag in header.split(","))
    return {tag if tag.startswith("W/") else f"W/{tag}" for tag in tags}
