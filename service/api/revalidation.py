"""Answers that a client may keep and asks about again: an ETag, and 304 while nothing changed.

(Every answer says `Cache-Control: private, no-cache`: keep it, and ask before each use.)

Sweeps and runs as they stand, and lists of them, are cheap to make: their tag is a hash of the
answer (`TaggedRoute`). What is computed of a sweep's measurements is not (`RevalidatedRoute`): that
tag goes by the sweeps' newest events (every change has one), the newest random return (the zero
of the normalised scale), the question, and this process: another version of the program may draw
the same data differently. It is read before the answer is made, so an answer can be newer than its
tag says and is then fetched once too often, never once too rarely.

These are the answers that are made of all that a sweep has measured, so they have a budget
(`service/api/load/read_budget.py`).
"""

import hashlib
import secrets
from collections.abc import AsyncIterator, Callable, Coroutine
from typing import Any

from fastapi import Depends, Request, Response
from fastapi.routing import APIRoute
from starlette.concurrency import run_in_threadpool

from algorithms.measurement import MEASURE_EVERY
from service.api.context import MAX_COMPARED, TheCompared, may_be_id
from service.api.load.read_budget import ReadBudget
from service.model.compared import SEPARATOR
from service.store.store import Store

PROCESS = secrets.token_hex(8)


class TaggedRoute(APIRoute):
    """A route whose answers are tagged by what they say."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Answer, or 304 where the client has just that."""
        answer = super().get_route_handler()

        async def tagged(request: Request) -> Response:
            response = await answer(request)
            if request.method != "GET" or response.status_code != 200:
                return response
            tag = weak_tag(response.body)
            if tag in known_tags(request.headers.get("if-none-match", "")):
                return Response(status_code=304, headers={"ETag": tag})
            response.headers["ETag"] = tag
            return response

        return tagged


class UnchangedError(Exception):
    """The client has the present answer."""


class RevalidatedRoute(APIRoute):
    """A route under `/sweeps/{sweep_id}` whose answers depend on that sweep, or those, alone.

    Its dependencies are who may call, then `REVALIDATED`: 304 is an answer too.
    """

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Answer 304 where the client has the present answer, else tag the new one."""
        answer = super().get_route_handler()

        async def revalidate(request: Request) -> Response:
            try:
                response = await answer(request)
            except UnchangedError:
                return Response(status_code=304, headers={"ETag": request.state.entity_tag})
            if response.status_code == 200:
                response.headers["ETag"] = request.state.entity_tag
            return response

        return revalidate


async def unless_unchanged(request: Request) -> None:
    """Note the tag of the answer to be made. Raises UnchangedError where the client has it."""
    tag = await run_in_threadpool(entity_tag, request)
    request.state.entity_tag = tag
    if tag in known_tags(request.headers.get("if-none-match", "")):
        raise UnchangedError


async def within_budget(request: Request, sweep: TheCompared) -> AsyncIterator[None]:
    """Wait for the turn of an answer that is made of all that the sweeps have measured."""
    budget: ReadBudget = request.app.state.read_budget
    async with budget.of(sweep.timesteps // MEASURE_EVERY):
        yield


REVALIDATED = (Depends(unless_unchanged), Depends(within_budget, scope="function"))


def entity_tag(request: Request) -> str | None:
    """Return the weak tag of the present answer; None where there is no such sweep."""
    store: Store = request.app.state.store
    version = [store.sweep_version(each) if may_be_id(each) else None for each in ids_of(request)]
    if None in version:
        return None
    question = (request.url.path, request.url.query, request.headers.get("accept", ""))
    return weak_tag(repr((PROCESS, version, question)).encode())


def weak_tag(content: bytes | memoryview) -> str:
    """Return the weak tag of what an answer says, or follows from."""
    return f'W/"{hashlib.sha256(content).hexdigest()[:32]}"'


def ids_of(request: Request) -> list[str]:
    """Return the ids in a path: a sweep's, or those of several compared."""
    sweep_id: str = request.path_params["sweep_id"]
    return sweep_id.split(SEPARATOR)[:MAX_COMPARED]


def known_tags(header: str) -> set[str]:
    """Read `If-None-Match`; a strong tag counts as its weak one."""
    tags = (tag.strip() for tag in header.split(","))
    return {tag if tag.startswith("W/") else f"W/{tag}" for tag in tags}
