"""The Python client: submit sweeps, follow them, fetch their curves.

    client = Client()                                   # the service on this machine
    sweep = client.submit({"algorithms": [{"name": "ddpg"}], "environments": ["Pendulum"],
                           "seeds": 4, "timesteps": 20_000})
    client.wait(sweep["id"])
    curves = client.curves(sweep["id"], normalized=True)

Every call answers the service's JSON as it stands in the OpenAPI document (`/api/v1/docs`).
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

import httpx2

Json = dict[str, Any]


class ServiceError(Exception):
    """The service refused a call or did not answer; the message says why and what to do."""

    def __init__(self, message: str, status: int | None = None) -> None:
        """`status` is the HTTP status, None where no answer came."""
        super().__init__(message)
        self.status = status


def find_token() -> str:
    """The service's token: `D3PG_TOKEN`, else the file `token` in `D3PG_DATA_DIR` (./d3pg-data).

    Raises ServiceError where neither is there.
    """
    if token := os.environ.get("D3PG_TOKEN"):
        return token
    file = Path(os.environ.get("D3PG_DATA_DIR") or "d3pg-data") / "token"
    try:
        return file.read_text(encoding="utf-8").strip()
    except OSError as error:
        raise ServiceError(
            f"No token: D3PG_TOKEN is not set and {file} cannot be read ({error.strerror}). "
            "Start the service here with `d3pg serve`, name its data directory with "
            "D3PG_DATA_DIR, or set D3PG_TOKEN."
        ) from error


class Client:
    """A connection to one service; usable as a context manager.

    `url` defaults to `D3PG_URL`, else this machine's port `D3PG_PORT` (8000); `token` to that of
    `find_token`.
    """

    def __init__(self, url: str | None = None, token: str | None = None) -> None:
        """Open no connection yet: the first call does."""
        here = f"http://127.0.0.1:{os.environ.get('D3PG_PORT') or 8000}"
        self.url = url or os.environ.get("D3PG_URL") or here
        self.token = token or find_token()
        self._http = httpx2.Client(
            base_url=self.url,
            headers={"Authorization": f"Bearer {self.token}"},
            timeout=60.0,
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

    def submit(self, request: Mapping[str, Any]) -> Json:
        """Queue a sweep; answers it with its id once every run is stored."""
        return self._json("POST", "/api/v1/sweeps", json=dict(request))

    def count(self, request: Mapping[str, Any]) -> Json:
        """What `submit` would queue, without queueing it."""
        return self._json("POST", "/api/v1/sweeps", json=dict(request), params={"dry_run": True})

    def sweep(self, sweep_id: str) -> Json:
        """A sweep: its status, counts of runs, progress and ETA."""
        return self._json("GET", f"/api/v1/sweeps/{sweep_id}")

    def sweeps(self) -> Iterator[Json]:
        """All sweeps, newest first."""
        return self._pages("/api/v1/sweeps")

    def runs(self, sweep_id: str, **filters: str) -> Iterator[Json]:
        """The runs of a sweep, filtered by `status`, `algorithm`, `environment`."""
        return self._pages(f"/api/v1/sweeps/{sweep_id}/runs", **filters)

    def run(self, run_id: str) -> Json:
        """One run."""
        return self._json("GET", f"/api/v1/runs/{run_id}")

    def cancel(self, identifier: str) -> Json:
        """Cancel a sweep, or a single run (whose id has the form `<sweep>-<number>`)."""
        resource = "runs" if "-" in identifier else "sweeps"
        return self._json("POST", f"/api/v1/{resource}/{identifier}/cancel")

    def measurements(self, run_id: str) -> Json:
        """Every measurement of a run."""
        return self._json("GET", f"/api/v1/runs/{run_id}/measurements")

    def curves(self, sweep_id: str, **options: str | bool | int) -> Json:
        """Mean and band over seeds; options as in `GET /sweeps/{id}/curves`."""
        return self._json("GET", f"/api/v1/sweeps/{sweep_id}/curves", params=options)

    def plot(
        self, sweep_id: str, form: Literal["png", "svg", "pdf"] = "png", **options: str | bool
    ) -> bytes:
        """The comparison figure as a file's bytes."""
        return self._call("GET", f"/api/v1/sweeps/{sweep_id}/plot.{form}", params=options).content

    def readiness(self) -> Json:
        """What `/readyz` says of database and cluster, ready or not."""
        return dict(self._call("GET", "/readyz", allowed=(503,)).json())

    def wait(
        self,
        sweep_id: str,
        timeout_seconds: float = float("inf"),
        progressed: Callable[[Json], None] | None = None,
        poll_seconds: float = 1.0,
    ) -> Json:
        """Block until every run of a sweep has ended; calls `progressed` (if given) at each look.

        A service that is away for a moment is waited for. Raises TimeoutError.
        """
        deadline = time.monotonic() + timeout_seconds
        while True:
            try:
                sweep = self.sweep(sweep_id)
            except ServiceError as error:
                if error.status is not None:
                    raise
            else:
                if progressed is not None:
                    progressed(sweep)
                if has_ended(sweep):
                    return sweep
            if time.monotonic() > deadline:
                raise TimeoutError(f"Sweep {sweep_id} has not ended within {timeout_seconds:g} s.")
            time.sleep(poll_seconds)

    def _pages(self, path: str, **params: str) -> Iterator[Json]:
        cursor: str | None = None
        while True:
            page = self._json("GET", path, params=params | ({"after": cursor} if cursor else {}))
            yield from page["items"]
            cursor = page["next"]
            if cursor is None:
                return

    def _json(self, method: str, path: str, **options: Any) -> Json:
        return dict(self._call(method, path, **options).json())

    def _call(
        self, method: str, path: str, allowed: tuple[int, ...] = (), **options: Any
    ) -> httpx2.Response:
        try:
            response = self._http.request(method, path, **options)
        except httpx2.TransportError as error:
            raise ServiceError(
                f"No service answers at {self.url} ({error}). Start one with `d3pg serve`, or "
                "name another with D3PG_URL."
            ) from error
        if response.is_success or response.status_code in allowed:
            return response
        raise ServiceError(problem_text(response), response.status_code)


def has_ended(sweep: Json) -> bool:
    """Whether no run of the sweep is queued or running."""
    return bool(sweep["runs"]["queued"] + sweep["runs"]["running"] == 0)


def problem_text(response: httpx2.Response) -> str:
    """A refusal (RFC 9457 problem) as text: what was wrong, field by field."""
    try:
        problem = response.json()
    except ValueError:
        return f"The service answered {response.status_code}: {response.text[:500]}"
    lines = [str(problem.get("detail") or problem.get("title") or response.status_code)]
    lines += [
        f"  {error.get('field') or error.get('pointer') or ''}: {error.get('message', error)}"
        for error in problem.get("errors") or []
        if isinstance(error, dict)
    ]
    return "\n".join(lines)
