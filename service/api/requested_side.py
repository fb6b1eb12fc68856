"""The process beside the service, as a request uses it: what its client gave up is not begun."""

from typing import Any

from anyio import from_thread
from fastapi import Request

from service.api.side_process import SideProcess


class RequestedSide:
    """A Side (see service/api/side_process.py) for one request, on a thread of its own."""

    def __init__(self, side: SideProcess, request: Request) -> None:
        """Call nothing yet."""
        self._side = side
        self._request = request

    def call(self, function: str, *arguments: Any) -> Any:
        """Return what the function returns, raise what it raises; or BusyError, TooSlowError."""
        return self._side.call(function, *arguments, is_wanted=self._is_wanted)

    def _is_wanted(self) -> bool:
        return not from_thread.run(self._request.is_disconnected)
