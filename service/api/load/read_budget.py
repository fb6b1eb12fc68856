"""The read budget: how many measurements concurrent answers may read together.

An answer about a large sweep needs memory for all that its runs measured. More answers at once
would not be ready sooner, since they share the processor. So they wait for their turn, in order.
"""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from service.api.refusals.problems import ServiceBusy

MOST_POINTS = 8_000_000
"""Some 25 bytes each. A sweep that has more is read alone."""
WAITING_SECONDS = 60.0


class ReadBudget:
    """Admits requests that read measurements; for one event loop."""

    def __init__(
        self, most_points: int = MOST_POINTS, waiting_seconds: float = WAITING_SECONDS
    ) -> None:
        """Admit the first requests at once."""
        self._most = most_points
        self._waiting_seconds = waiting_seconds
        self._in_use = 0
        self._turn = asyncio.Lock()
        self._freed = asyncio.Event()

    @asynccontextmanager
    async def of(self, points: int) -> AsyncIterator[None]:
        """Read so many points inside. Raises ServiceBusy if the turn does not come in time."""
        asked = min(points, self._most)
        try:
            async with asyncio.timeout(self._waiting_seconds), self._turn:
                while self._in_use + asked > self._most:
                    self._freed.clear()
                    await self._freed.wait()
        except TimeoutError:
            raise ServiceBusy(
                f"Other requests read large sweeps; this one waited {self._waiting_seconds:g} s "
                "for its turn. Try again later."
            ) from None
        self._in_use += asked
        try:
            yield
        finally:
            self._in_use -= asked
            self._freed.set()
