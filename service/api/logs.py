"""Logging: one line an event; colour for people at a terminal, JSON otherwise.

structlog and the standard library's loggers (uvicorn, alembic) end in the same handler, and every
line of a request carries its request id.
"""

import logging
import sys
import time
from collections.abc import MutableMapping
from http import HTTPStatus
from typing import Any

import structlog
from asgi_correlation_id import correlation_id
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.metrics import HTTP_SECONDS
from service.model.caller import Caller

METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})

log = structlog.get_logger(__name__)


def configure_logging(level: int = logging.INFO) -> None:
    """Send every logger's lines to standard error."""
    shared: list[structlog.types.Processor] = [
        structlog.contextvars.merge_contextvars,
        _add_request_id,
        structlog.stdlib.add_log_level,
        structlog.stdlib.add_logger_name,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
        structlog.processors.StackInfoRenderer(),
        structlog.processors.format_exc_info,
    ]
    structlog.configure(
        processors=[
            structlog.stdlib.filter_by_level,
            *shared,
            structlog.stdlib.ProcessorFormatter.wrap_for_formatter,
        ],
        logger_factory=structlog.stdlib.LoggerFactory(),
        wrapper_class=structlog.stdlib.BoundLogger,
        cache_logger_on_first_use=True,
    )
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(
            foreign_pre_chain=shared,
            processors=[
                structlog.stdlib.ProcessorFormatter.remove_processors_meta,
                _renderer(),
            ],
        )
    )
    logging.basicConfig(handlers=[handler], level=level, force=True)
    # Its access lines hold the query, and with it the code of the sign-in link; ours do not.
    logging.getLogger("uvicorn.access").disabled = True


class AccessLog:
    """Logs every request as it ends: method, path without its query, status, seconds, caller.

    For the metrics it notes how long each answer took to start, by the route's template.
    """

    def __init__(self, app: ASGIApp) -> None:
        """Log what `app` answers."""
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on and watch its answer start."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        status = 0
        started = time.perf_counter()

        async def send_and_note(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                note_request(scope, status, time.perf_counter() - started)
            await send(message)

        try:
            await self.app(scope, receive, send_and_note)
        except Exception:
            status = status or HTTPStatus.INTERNAL_SERVER_ERROR.value
            raise
        finally:
            # /healthz is asked every few seconds by whoever supervises the process.
            caller: Caller | None = scope.get("state", {}).get("caller")
            write = log.debug if scope["path"] == "/healthz" else log.info
            write(
                "request",
                method=scope["method"],
                path=scope["path"],
                status=status,
                seconds=round(time.perf_counter() - started, 4),
                caller=caller.name if caller is not None else None,
            )


def note_request(scope: Scope, status: int, seconds: float) -> None:
    """Count a request under its route's template: unknown paths get no label of their own."""
    method = scope["method"] if scope["method"] in METHODS else "other"
    HTTP_SECONDS.labels(method, _template(scope), status).observe(seconds)


def _template(scope: Scope) -> str:
    """Return the path's template. A route knows the part after its router's prefix."""
    route = getattr(scope.get("route"), "path", None)
    if route is None:
        return "none"
    prefix = scope["path"].split("/")[: -route.count("/")]
    return f"{'/'.join(prefix)}{route}"


def _renderer() -> structlog.types.Processor:
    if sys.stderr.isatty():
        return structlog.dev.ConsoleRenderer()
    return structlog.processors.JSONRenderer()


def _add_request_id(
    _logger: Any, _method: str, event: MutableMapping[str, Any]
) -> MutableMapping[str, Any]:
    if (request_id := correlation_id.get()) is not None:
        event["request_id"] = request_id
    return event
