"""The connection of a client: calls, answers page by page, answers as they arrive."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Self, TypeVar

import httpx2
from pydantic import BaseModel

from service.address import is_on_loopback
from service.api.schemas.page import Page
from service.client.access import find_token, own_url, trusted
from service.client.errors import ServiceError, problem_text
from service.model.run_name import is_run

API = "/api/v1"

Option = str | bool | int
Answer = TypeVar("Answer", bound=BaseModel)


class Connection:
    """A connection to one service, and the ways to call it.

    Attributes:
        url: the service's address.
        token: the access token.
    """

    def __init__(
        self, url: str | None = None, token: str | None = None, timeout_seconds: float = 60.0
    ) -> None:
        """Make a client; the first call opens the connection.

        Args:
            url: the service's address; by default `D3PG_URL`, else the one that a service with
                `D3PG_HOST` (127.0.0.1) and `D3PG_PORT` (8000) listens on. A service on this machine
                is called directly, even if the environment names proxies.
            token: the access token; by default that of `find_token`.
            timeout_seconds: how long each call waits for the service.

        Raises:
            ServiceError: if no token is given or found.
        """
        self.url = url or os.environ.get("D3PG_URL") or own_url()
        self.token = token or find_token()
        self._http = httpx2.Client(
            base_url=self.url,
            headers={"Authorization": f"Bearer {self.token}"},
            timeout=timeout_seconds,
            trust_env=not is_on_loopback(self.url),
            verify=trusted(),
        )

    def __enter__(self) -> Self:
        """Close with the block."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the connections."""
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def _get(self, model: type[Answer], path: str, **params: Any) -> Answer:
        return model.model_validate_json(self._call("GET", path, params=params).content)

    def _list(self, model: type[Answer], path: str) -> list[Answer]:
        return [model.model_validate(each) for each in self._call("GET", path).json()]

    def _pages(self, model: type[Page[Answer]], path: str, **params: Any) -> Iterator[Answer]:
        cursor: dict[str, str] = {}
        while True:
            page = self._get(model, path, **params, **cursor)
            yield from page.items
            if page.next is None:
                return
            cursor = {"after": page.next}

    def _call(
        self,
        method: str,
        path: str,
        allowed: tuple[int, ...] = (),
        prefix: str = API,
        **options: Any,
    ) -> httpx2.Response:
        try:
            response = self._http.request(method, prefix + path, **options)
        except httpx2.TransportError as error:
            raise self._silence(error) from error
        if response.is_success or response.status_code in allowed:
            return response
        raise ServiceError(problem_text(response), response.status_code)

    @contextmanager
    def _streamed(self, path: str, **params: Any) -> Iterator[httpx2.Response]:
        """An answer that is read as it arrives."""
        try:
            with self._http.stream("GET", API + path, params=params) as response:
                if not response.is_success:
                    response.read()
                    raise ServiceError(problem_text(response), response.status_code)
                yield response
        except httpx2.TransportError as error:
            raise self._silence(error) from error

    def _silence(self, error: httpx2.TransportError) -> ServiceError:
        return ServiceError(
            f"No service answers at {self.url} ({error}). Start one with `d3pg serve`, or "
            "name another with D3PG_URL."
        )


def path_of(identifier: str) -> str:
    """Where a sweep or a run is found."""
    return f"/{'runs' if is_run(identifier) else 'sweeps'}/{identifier}"
