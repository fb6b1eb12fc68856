"""`d3pg logs`: what a worker printed, and what is new of it."""

import json
from collections.abc import Iterator

import pytest

from service.cli.results.logs import added
from service.client import Client
from service.store.store import Store
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import changed
from workers.messages.progress import Progress

SMALL = changed(seeds=2, algorithms=[{"name": "ddpg"}], environments=["Pendulum"])


def test_the_last_lines_are_printed(d3pg: Command, service: Client, store: Store) -> None:
    run_id = f"{service.submit(SMALL).id}-1"
    waiting = d3pg("logs", run_id)
    assert waiting.stdout == ""
    assert f"No worker has claimed {run_id} yet." in waiting.stderr
    claim = store.claim_cohort("worker-3", 60.0)
    assert claim is not None
    store.record(claim, Progress(800, log_tail="[red]one[/red]\n\x1b two\n"))
    shown = d3pg("logs", run_id)
    assert shown.stdout == "[red]one[/red]\n  two\n"
    assert "attempt 1 on worker-3" in shown.stderr
    answer = as_json(d3pg("logs", run_id, "--json"))
    assert (answer["attempt"], answer["log_tail"]) == (1, "[red]one[/red]\n\x1b two\n")


def test_a_run_that_is_unknown_is_refused(d3pg: Command) -> None:
    assert "There is no run" in str(d3pg("logs", f"{'0' * 12}-0", code=1).exception)


@pytest.mark.parametrize("form", ["text", "json"])
def test_it_is_followed_to_the_end(
    d3pg: Command, service: Client, store: Store, monkeypatch: pytest.MonkeyPatch, form: str
) -> None:
    """Each pause between two looks, the worker has gone on."""
    run_id = f"{service.submit(SMALL).id}-0"

    def life() -> Iterator[None]:
        yield
        first = store.claim_cohort("worker-1", 60.0)
        assert first is not None
        store.record(first, Progress(800, log_tail="one\n"))
        yield
        yield
        store.record(first, Progress(1600, log_tail="one\ntwo\n"))
        yield
        store.release(first, "the service was stopped")
        second = store.claim_cohort("worker-2", 60.0)
        assert second is not None
        store.record(second, Progress(2400, log_tail="one\n"))
        yield
        store.record(second, Progress(4000, log_tail="one\nlast\n", finished=(0, 1)))
        yield

    going_on = life()
    monkeypatch.setattr("time.sleep", lambda seconds: next(going_on))
    shown = d3pg("logs", run_id, "--follow", *(["--json"] if form == "json" else []))
    if form == "text":
        assert shown.stdout == "one\ntwo\none\nlast\n"
        assert shown.stderr == "attempt 1 on worker-1\nattempt 2 on worker-2\n"
    else:
        told = [json.loads(line) for line in shown.stdout.splitlines()]
        assert [(each["attempt"], each["log_tail"]) for each in told] == [
            (1, "one\n"), (1, "one\ntwo\n"), (2, "one\n"), (2, "one\nlast\n"),
        ]  # fmt: skip


@pytest.mark.parametrize(
    ("before", "after", "new"),
    [
        ("", "one\n", "one\n"),
        ("one\n", "one\ntwo\n", "two\n"),
        ("one\nhalf", "one\nhalf a line\n", " a line\n"),
        ("one\ntwo\nthree\n", "two\nthree\nfour\n", "four\n"),
        ("one\ntwo\nhalf", "two\nhalf a line\n", "half a line\n"),
        ("one\n 10%", "one\n 20%", " 20%"),
        ("one\ntwo\n", "eight\nnine\n", "eight\nnine\n"),
    ],
)
def test_what_is_new_of_a_log(before: str, after: str, new: str) -> None:
    assert added(before, after) == new
