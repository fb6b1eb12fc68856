"""Calling webhooks when sweeps have ended; on a thread of its own, so that nothing waits for it.

An end is delivered at least once: tried again after 2, 4, 8 ... 600 seconds, up to 20 times.
Redirects are not followed, and only the status of an answer is read.
"""

import time
from collections.abc import Callable, Collection

import httpx2
import structlog

from service.model.webhook import DELIVERY, SIGNATURE, Due, resolved_refusal, signature
from service.queue.rounds import Rounds
from service.store.store import Store

log = structlog.get_logger(__name__)

AT_ONCE = 16
TIMEOUT_SECONDS = 10.0
ROUND_SECONDS = 1.0


class Webhooks(Rounds):
    """Looks every second for sweeps that have ended."""

    def __init__(
        self,
        store: Store,
        secret: Callable[[], str],
        hosts: Collection[str],
        service_url: str,
        transport: httpx2.BaseTransport | None = None,
    ) -> None:
        """Begin nothing yet. If there are `hosts`, only these are called; the rest is for tests."""
        super().__init__("webhooks", ROUND_SECONDS)
        self._store = store
        self._secret = secret
        self._hosts = hosts
        self._service_url = service_url
        # No proxy of the environment: what may be reached is what is reached.
        self._http = httpx2.Client(
            timeout=TIMEOUT_SECONDS, follow_redirects=False, trust_env=False, transport=transport
        )

    def work(self) -> bool:
        """Tell some."""
        found = self._store.due_webhooks(AT_ONCE)
        for each in found:
            problem = self._told(each)
            if problem:
                log.warning("a webhook was not told", sweep=each.sweep.id, reason=problem)
            self._store.note_webhook(each, problem)
        return len(found) == AT_ONCE

    def _told(self, due: Due) -> str:
        """Send it, and return what was wrong; empty if nothing was."""
        body, at = due.body(self._service_url), int(time.time())
        headers = {
            "Content-Type": "application/json",
            "User-Agent": "d3pg",
            DELIVERY: due.name,
            SIGNATURE: signature(self._secret(), body, at),
        }
        try:
            if refused := resolved_refusal(due.url, self._hosts):
                return refused
            with self._http.stream("POST", due.url, content=body, headers=headers) as answer:
                status = answer.status_code
        except (httpx2.HTTPError, httpx2.InvalidURL, OSError) as error:
            return f"{type(error).__name__}: {error}"[:500]
        return "" if 200 <= status < 300 else f"it answered {status}"
