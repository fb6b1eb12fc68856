"""Streams of the event log: everything once and in order, resumable, cheap to keep open."""

import asyncio
import math
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Any

import pytest
from sqlalchemy.exc import OperationalError

from service.api import event_feed
from service.api.event_feed import EventFeed, Message, coalesce
from service.model.event import Event
from service.store.store import Store
from tests.service.training import train
from workers.messages.run_spec import RunSpec


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(event_feed, "PERIOD_SECONDS", 0.01)


def make_sweep(store: Store, seeds: int = 2) -> str:
    specs = [RunSpec("ddpg", "Pendulum", seed, timesteps=1600) for seed in range(seeds)]
    return store.create_sweep("a sweep", 0, {}, specs, environment_versions={"Pendulum": 1}).id


def in_a_loop(test: Callable[[], Awaitable[None]]) -> None:
    async def within_time() -> None:
        async with asyncio.timeout(20):
            await test()

    asyncio.run(within_time())


async def take(stream: AsyncIterator[Message], count: int) -> list[Message]:
    return [await anext(stream) for _ in range(count)]


def event(number: int, kind: str, **payload: Any) -> Event:
    return Event(number, "s", kind, {"sweep_id": "s", **payload}, 0.0)


def test_a_new_stream_says_reload_and_then_what_changes(store: Store) -> None:
    make_sweep(store)

    async def test() -> None:
        stream = EventFeed(store).follow(None, None)
        (first,) = await take(stream, 1)
        assert first == Message(store.last_event_id(), "reload", {"event_id": first.id})
        sweep_id = make_sweep(store)
        (second,) = await take(stream, 1)
        assert second.kind == "sweep"
        assert second.payload["sweep_id"] == sweep_id
        assert second.id > first.id
        await stream.aclose()

    in_a_loop(test)


def test_resuming_misses_nothing_and_repeats_nothing(store: Store) -> None:
    for _ in range(3):
        make_sweep(store)
    logged = [each.id for each in store.events_after(0)]

    async def test() -> None:
        feed = EventFeed(store)
        for after in range(len(logged)):
            stream = feed.follow(logged[after] - 1, None)
            assert [each.id for each in await take(stream, len(logged) - after)] == logged[after:]
            await stream.aclose()

    in_a_loop(test)


def test_one_sweeps_stream_has_its_own_changes_alone(store: Store) -> None:
    first, second = make_sweep(store), make_sweep(store)

    async def test() -> None:
        stream = EventFeed(store).follow(0, second)
        assert (await take(stream, 1))[0].payload["sweep_id"] == second
        store.move_sweep(first, "cancel")
        store.move_sweep(second, "cancel")
        messages = await take(stream, 3)
        assert [each.kind for each in messages] == ["sweep", "run", "run"]
        assert {each.payload["sweep_id"] for each in messages} == {second}
        await stream.aclose()

    in_a_loop(test)


@pytest.mark.parametrize("after", [10**9, -(10**9)])
def test_a_position_out_of_reach_starts_anew(store: Store, after: int) -> None:
    make_sweep(store)

    async def test() -> None:
        stream = EventFeed(store).follow(after, None)
        assert (await take(stream, 1))[0].kind == "reload"
        await stream.aclose()

    in_a_loop(test)


def test_a_slow_reader_reads_on_from_the_store(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What has left memory is not lost: the position is all that a stream holds."""
    monkeypatch.setattr(event_feed, "KEPT_EVENTS", 4)
    monkeypatch.setattr(event_feed, "PAGE", 3)

    async def test() -> None:
        feed = EventFeed(store)
        slow, quick = feed.follow(0, None), feed.follow(0, None)
        sweep_id = make_sweep(store, seeds=40)
        await asyncio.to_thread(store.move_sweep, sweep_id, "cancel")
        logged = [each.id for each in store.events_after(0)]
        assert len(logged) == 42
        assert [each.id for each in await take(quick, 42)] == logged
        assert [each.id for each in await take(slow, 42)] == logged
        await quick.aclose()
        await slow.aclose()

    in_a_loop(test)


def test_nothing_is_left_of_streams_that_ended(store: Store) -> None:
    async def test() -> None:
        feed = EventFeed(store)
        streams = [feed.follow(None, None) for _ in range(500)]
        await asyncio.gather(*(anext(stream) for stream in streams))
        assert len(asyncio.all_tasks()) == 2
        for stream in streams:
            await stream.aclose()
        await asyncio.sleep(0.05)
        assert len(asyncio.all_tasks()) == 1
        stream = feed.follow(None, None)
        assert (await take(stream, 1))[0].kind == "reload"
        await stream.aclose()

    in_a_loop(test)


def test_a_database_that_fails_is_asked_again(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    working = store.events_after
    failures = iter(range(3))

    def fail_thrice(*arguments: Any) -> list[Event]:
        if next(failures, None) is not None:
            raise OperationalError("SELECT", {}, Exception("disk I/O error"))
        return working(*arguments)

    async def test() -> None:
        stream = EventFeed(store).follow(None, None)
        await take(stream, 1)
        monkeypatch.setattr(store, "events_after", fail_thrice)
        make_sweep(store)
        assert (await take(stream, 1))[0].kind == "sweep"
        await stream.aclose()

    in_a_loop(test)


def test_measurements_of_a_run_are_merged_under_the_first_id() -> None:
    events = [
        event(1, "measurements", run_ids=["s-0"], **{"from": 800, "to": 800}),
        event(2, "run", run_id="s-1", status="running"),
        event(3, "measurements", run_ids=["s-1"], **{"from": 800, "to": 1600}),
        event(4, "measurements", run_ids=["s-0"], **{"from": 1600, "to": 2400}),
    ]
    messages = coalesce(events)
    assert [(each.id, each.kind) for each in messages] == [
        (1, "measurements"),
        (2, "run"),
        (3, "measurements"),
    ]
    assert messages[0].payload == {"sweep_id": "s", "run_id": "s-0", "from": 800, "to": 2400}
    assert messages[2].payload["to"] == 1600


def test_a_stream_that_breaks_anywhere_hears_of_every_run() -> None:
    """An event tells of several runs, in a message each; whoever had some of them has them all."""
    events = [
        event(1, "measurements", run_ids=["s-0", "s-1", "s-2"], **{"from": 800, "to": 800}),
        event(2, "measurements", run_ids=["s-1", "s-3", "s-0"], **{"from": 1600, "to": 2400}),
        event(3, "run", run_id="s-3", status="succeeded"),
    ]
    messages = coalesce(events)
    assert [each.id for each in messages] == [0, 0, 1, 2, 3]
    for heard in range(len(messages)):
        position = messages[heard - 1].id if heard else 0
        rest = coalesce([each for each in events if each.id > position])
        told = [*messages[:heard], *rest]
        for event_told in events[:2]:
            for run_id in event_told.payload["run_ids"]:
                spans = [m.payload for m in told if m.payload["run_id"] == run_id]
                assert (
                    min(each.get("from", math.inf) for each in spans) <= event_told.payload["from"]
                )
                assert max(each.get("to", -math.inf) for each in spans) >= event_told.payload["to"]


def test_training_is_told_as_it_goes(store: Store) -> None:
    sweep_id = make_sweep(store)

    async def test() -> None:
        stream = EventFeed(store).follow(None, sweep_id)
        await take(stream, 1)
        await asyncio.to_thread(train, store, 2, lambda spec, timestep: -1.0)
        told: dict[str, list[Any]] = {}
        while len(told.get("succeeded", [])) < 2:
            (message,) = await take(stream, 1)
            kind = message.payload.get("status", message.kind)
            told.setdefault(kind, []).append(message.payload)
        assert {each["run_id"] for each in told["running"]} == {f"{sweep_id}-0", f"{sweep_id}-1"}
        spans = {each["run_id"]: (each["from"], each["to"]) for each in told["measurements"]}
        assert spans == {f"{sweep_id}-0": (800, 1600), f"{sweep_id}-1": (800, 1600)}
        await stream.aclose()

    in_a_loop(test)
