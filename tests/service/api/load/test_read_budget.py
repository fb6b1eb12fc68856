"""The read budget: no more points at once than it has, first come, first served."""

import asyncio

import pytest

from service.api.load.read_budget import ReadBudget
from service.api.refusals.problems import ServiceBusy


class Reads:
    """Reads that begin and end as a test says."""

    def __init__(self, budget: ReadBudget) -> None:
        self.begun: list[str] = []
        self._budget = budget
        self._ends: dict[str, asyncio.Event] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}

    async def ask(self, name: str, points: int) -> None:
        self._ends[name] = asyncio.Event()
        self._tasks[name] = asyncio.create_task(self._read(name, points))
        await settled()

    async def end(self, name: str) -> None:
        self._ends[name].set()
        await self._tasks[name]
        await settled()

    async def _read(self, name: str, points: int) -> None:
        async with self._budget.of(points):
            self.begun.append(name)
            await self._ends[name].wait()


async def settled() -> None:
    """Let every task go on until it waits."""
    for _ in range(20):
        await asyncio.sleep(0)


def test_who_does_not_fit_waits_and_so_do_those_behind() -> None:
    async def scene() -> None:
        reads = Reads(ReadBudget(10))
        await reads.ask("six", 6)
        await reads.ask("four", 4)
        await reads.ask("five", 5)
        await reads.ask("one", 1)
        assert reads.begun == ["six", "four"]
        await reads.end("four")
        assert reads.begun == ["six", "four"], "five do not fit, and one came later"
        await reads.end("six")
        assert reads.begun == ["six", "four", "five", "one"]
        await reads.end("five")
        await reads.end("one")

    asyncio.run(scene())


def test_what_is_larger_than_the_budget_is_read_alone() -> None:
    async def scene() -> None:
        reads = Reads(ReadBudget(10))
        await reads.ask("huge", 1000)
        await reads.ask("tiny", 1)
        assert reads.begun == ["huge"]
        await reads.end("huge")
        assert reads.begun == ["huge", "tiny"]
        await reads.end("tiny")

    asyncio.run(scene())


def test_who_waits_too_long_is_told_so_and_holds_nobody_up() -> None:
    async def scene() -> None:
        budget = ReadBudget(10, waiting_seconds=0.0)
        async with budget.of(10):
            with pytest.raises(ServiceBusy) as refusal:
                async with budget.of(1):
                    pass
        assert "Try again later" in str(refusal.value.detail)
        async with budget.of(10):
            pass

    asyncio.run(scene())
