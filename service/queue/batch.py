"""Commands that are run together: reports of different workers, their writes, their claims.

So the news of many workers is one transaction, and a thousand workers cost one wait for the disk.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from itertools import islice, takewhile

from service.queue.messages import ClaimCohort, Command, PoolLost, QueueEvent, Record

TOGETHER: Mapping[type[Command], int] = {Record: 256, ClaimCohort: 32}
"""Commands in one transaction, at most, so that it delays nothing else for long."""


def take_next(events: deque[QueueEvent]) -> list[QueueEvent]:
    """Take the first report of each worker out, in order; the loss of the pool only when first.

    Reports of different workers have nothing to do with each other; those of one keep their order.
    """
    if events and isinstance(events[0], PoolLost):
        return [events.popleft()]
    first: dict[str, QueueEvent] = {}
    later: list[QueueEvent] = []
    while events and not isinstance(events[0], PoolLost):
        event = events.popleft()
        if first.setdefault(_worker(event), event) is not event:
            later.append(event)
    events.extendleft(reversed(later))
    return list(first.values())


def _worker(event: QueueEvent) -> str:
    """The worker that an event is about."""
    return getattr(event, "worker", "")


def next_together(commands: Sequence[Command]) -> list[Command]:
    """Return the commands at the head that are run together: of one kind, or just one."""
    kind = type(commands[0])
    alike = takewhile(lambda command: type(command) is kind, commands)
    return list(islice(alike, TOGETHER.get(kind, 1)))
