"""The application: routes, what stands in front of them, and what they are given.

From outside in: the public prefix, request id, access log, the guard (host, origin, token), the
body limit, routes, each of which says who may call it.
Whoever makes the application opens and closes store and dispatcher; no Ray, torch or matplotlib
here: figures are drawn in a process beside (`service/api/load/side_process.py`).
"""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from asgi_correlation_id import CorrelationIdMiddleware
from fastapi import APIRouter, FastAPI
from starlette.concurrency import run_in_threadpool

from service.api.access.access_token import access_token
from service.api.access.authority import refuse_undeclared
from service.api.access.cookie import session_cookie
from service.api.access.guard import Guard
from service.api.access.register import Register
from service.api.body_limit import BodyLimit
from service.api.context import Workforce
from service.api.diagnoser import LIMIT_SECONDS, Diagnoser
from service.api.event_feed import EventFeed
from service.api.invalid_request import refuse_invalid
from service.api.load.read_budget import ReadBudget
from service.api.load.side_process import SideProcess
from service.api.logs import AccessLog
from service.api.place import PublicPrefix
from service.api.refusals.problem_schema import describe_problems
from service.api.refusals.problems import install_problem_handlers
from service.api.routes import (
    catalogue,
    documentation,
    events,
    growth,
    health,
    moves,
    pages,
    pictures,
    policies,
    rollouts,
    runs,
    submissions,
    sweeps,
    workers,
)
from service.api.routes.people import sessions, shares, signin, users
from service.api.routes.results import curves, diagnoses, figures, measurements, report, scores
from service.settings import Settings
from service.store.store import Store
from service.task_shelf import TaskShelf

PREFIX = "/api/v1"
RESOURCES = (
    submissions,
    sweeps,
    runs,
    moves,
    growth,
    rollouts,
    policies,
    measurements,
    curves,
    scores,
    figures,
    report,
    diagnoses,
    events,
    catalogue,
    pictures,
    workers,
    users,
    shares,
    sessions,
)


@asynccontextmanager
async def lifespan(app: FastAPI) -> AsyncIterator[None]:
    """Start and close what the application runs itself."""
    app.state.diagnoser.start()
    yield
    await run_in_threadpool(app.state.diagnoser.stop)
    await run_in_threadpool(app.state.side.close)


def create_app(
    settings: Settings, store: Store, dispatcher: Workforce, shelf: TaskShelf | None = None
) -> FastAPI:
    """Make the application on an open store; `dispatcher` says whether runs can start."""
    public = settings.public
    app = FastAPI(
        docs_url=None,
        redoc_url=None,
        openapi_url=None,  # it has a route that says who may read it
        title="d3pg",
        summary="Sweeps of learning control with differentiable physics.",
        version="1",
        servers=[{"url": public.prefix}] if public.prefix else None,
        redirect_slashes=False,
        generate_unique_id_function=lambda route: route.name,
        lifespan=lifespan,
    )
    token = access_token(settings)
    register = Register(store, token)
    cookie = session_cookie(token, public)
    app.state.settings = settings
    app.state.register = register
    app.state.cookie = cookie
    app.state.store = store
    app.state.dispatcher = dispatcher
    app.state.event_feed = EventFeed(store)
    app.state.side = SideProcess()
    app.state.read_budget = ReadBudget()
    app.state.checkpoints = settings.checkpoint_place
    app.state.webhook_hosts = settings.webhook_hosts
    app.state.worker_memory = settings.run_memory
    app.state.shelf = shelf or TaskShelf(settings.data_dir)
    app.state.diagnoser = Diagnoser(
        store, settings.checkpoint_place, SideProcess(LIMIT_SECONDS), app.state.shelf
    )
    install_problem_handlers(app, refuse_invalid)
    api = APIRouter(prefix=PREFIX)
    for resource in RESOURCES:
        api.include_router(resource.router)
    for router in (api, health.router, signin.router):
        app.include_router(router)
    documentation.add_documentation(app, public.prefix)
    pages.add_pages(app)
    describe_problems(app)
    app.add_middleware(BodyLimit)
    app.add_middleware(Guard, settings=settings, register=register, cookie=cookie)
    app.add_middleware(AccessLog)
    app.add_middleware(CorrelationIdMiddleware)
    app.add_middleware(PublicPrefix, prefix=public.prefix)
    refuse_undeclared(app)
    return app
