"""What is done at once: never two reports of one worker, never a write before its turn."""

from collections import deque

import pytest

from service.model.claim import Claim
from service.queue.batch import TOGETHER, next_together, take_next
from service.queue.messages import (
    AskCancelling,
    ClaimCohort,
    Command,
    Lose,
    PoolLost,
    QueueEvent,
    Record,
)
from workers.messages.progress import Progress
from workers.messages.report import Ended, News, Ready

CLAIM = Claim("w", 15.0, ())
LOST = PoolLost("its head is gone", "12:00:00")


def news(worker: str, timestep: int = 800) -> News:
    return News(worker, "cohort", Progress(timestep))


def taken(events: list[QueueEvent]) -> list[list[QueueEvent]]:
    left = deque(events)
    batches = []
    while left:
        batches.append(take_next(left))
    return batches


def test_different_workers_are_heard_at_once_and_each_in_its_order() -> None:
    events: list[QueueEvent] = [
        news("a"),
        Ended("a", "cohort"),
        news("b"),
        news("b", 1600),
        news("c"),
    ]
    assert taken(events) == [[news("a"), news("b"), news("c")], [events[1], events[3]]]


def test_what_a_worker_repeats_is_heard_twice() -> None:
    assert taken([news("a"), news("a")]) == [[news("a")], [news("a")]]


def test_the_loss_of_the_pool_is_heard_after_what_came_before_and_alone() -> None:
    events: list[QueueEvent] = [news("a"), news("a", 1600), LOST, Ready("a", 1, "here")]
    assert taken(events) == [[events[0]], [events[1]], [LOST], [events[3]]]


RECORDS: list[Command] = [Record(CLAIM, news(str(worker))) for worker in range(1000)]
CLAIMS: list[Command] = [ClaimCohort(str(worker), 15.0, 16) for worker in range(1000)]


@pytest.mark.parametrize("alike", [RECORDS[:2], CLAIMS[:2]])
def test_what_is_alike_at_the_head_is_done_together(alike: list[Command]) -> None:
    lose = Lose(CLAIM, "its worker was lost")
    assert next_together([*alike, lose, alike[0]]) == alike
    assert next_together([lose, *alike]) == [lose]
    assert next_together([AskCancelling(), *alike]) == [AskCancelling()]
    assert next_together([RECORDS[0], CLAIMS[0]]) == [RECORDS[0]]


@pytest.mark.parametrize("commands", [RECORDS, CLAIMS])
def test_no_transaction_takes_more_than_its_limit(commands: list[Command]) -> None:
    assert len(next_together(commands)) == TOGETHER[type(commands[0])]
