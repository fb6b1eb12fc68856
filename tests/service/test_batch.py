"""What is done at once: never two reports of one worker, never a write before its turn."""

from collections import deque

from service.batch import RECORDS_LIMIT, next_together, take_next
from service.claim import Claim
from service.scheduler_messages import AskCancelling, Command, Event, Lose, PoolLost, Record
from workers.progress import Progress
from workers.report import Ended, News, Ready

CLAIM = Claim("w", 15.0, ())
LOST = PoolLost("its head is gone", "12:00:00")


def news(worker: str, timestep: int = 800) -> News:
    return News(worker, "cohort", Progress(timestep))


def taken(events: list[Event]) -> list[list[Event]]:
    left = deque(events)
    batches = []
    while left:
        batches.append(take_next(left))
    return batches


def test_different_workers_are_heard_at_once_and_each_in_its_order() -> None:
    events: list[Event] = [news("a"), Ended("a", "cohort"), news("b"), news("b", 1600), news("c")]
    assert taken(events) == [[news("a"), news("b"), news("c")], [events[1], events[3]]]


def test_what_a_worker_repeats_is_heard_twice() -> None:
    assert taken([news("a"), news("a")]) == [[news("a")], [news("a")]]


def test_the_loss_of_the_pool_is_heard_after_what_came_before_and_alone() -> None:
    events: list[Event] = [news("a"), news("a", 1600), LOST, Ready("a", 1, "here")]
    assert taken(events) == [[events[0]], [events[1]], [LOST], [events[3]]]


def test_records_at_the_head_are_written_together() -> None:
    records: list[Command] = [Record(CLAIM, news("a")), Record(CLAIM, news("b"))]
    lose = Lose(CLAIM, "its worker was lost")
    assert next_together([*records, lose, records[0]]) == records
    assert next_together([lose, *records]) == [lose]
    assert next_together([AskCancelling(), *records]) == [AskCancelling()]


def test_no_transaction_takes_more_than_its_limit() -> None:
    records = [Record(CLAIM, news(str(worker))) for worker in range(2 * RECORDS_LIMIT + 1)]
    assert len(next_together(records)) == RECORDS_LIMIT
