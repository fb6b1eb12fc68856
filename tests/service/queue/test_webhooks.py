"""Webhooks: who is told, once more after each failure, and never in the way."""

import hashlib
import hmac
import json
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx2
import pytest
from sqlalchemy import update

from service.model.webhook import refusal, webhook_url
from service.queue.webhooks import Webhooks
from service.store.claiming.webhooks import MOST_TRIES
from service.store.store import Store
from service.store.tables import sweeps
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec

URL = "http://127.0.0.1:9/hook?key=1"
REQUEST = {"seeds": 2}


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store.open(f"sqlite:///{tmp_path / 'd3pg.sqlite'}")
    yield opened
    opened.close()


def submitted(store: Store, url: str | None = URL) -> str:
    specs = [RunSpec("ddpg", "Pendulum", seed, timesteps=1600) for seed in range(2)]
    versions = {"Pendulum": 1}
    return store.create_sweep("x", 0, REQUEST, specs, environment_versions=versions, webhook=url).id


def train(store: Store) -> None:
    while (claim := store.claim_cohort("w", 60.0)) is not None:
        store.record(claim, Progress(1600, finished=tuple(s.seed for s in claim.specs)))


class Receiver:
    """Answers with these statuses, then with the last one; an exception is raised."""

    def __init__(self, *answers: int | Exception) -> None:
        self.answers = list(answers)
        self.heard: list[httpx2.Request] = []

    def __call__(self, request: httpx2.Request) -> httpx2.Response:
        self.heard.append(request)
        answer = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
        if isinstance(answer, Exception):
            raise answer
        return httpx2.Response(answer, headers={"Location": "http://127.0.0.1:9/other"})


Telling = Callable[..., Webhooks]


@pytest.fixture
def telling(store: Store) -> Telling:
    def make(receiver: Receiver, hosts: tuple[str, ...] = ()) -> Webhooks:
        transport = httpx2.MockTransport(receiver)
        return Webhooks(store, lambda: "secret", hosts, "http://here:8000", transport)

    return make


def now_due(store: Store) -> None:
    """Let the time of a wait pass."""
    store.write(lambda c: c.execute(update(sweeps).values(webhook_not_before=0.0)))


def test_the_end_of_a_sweep_is_told_once_and_signed(store: Store, telling: Telling) -> None:
    sweep_id = submitted(store)
    submitted(store, url=None)
    receiver = Receiver(204)
    webhooks = telling(receiver)
    webhooks.work()
    assert receiver.heard == []
    train(store)
    for _ in range(2):
        webhooks.work()
    [request] = receiver.heard
    assert (request.method, str(request.url)) == ("POST", URL)
    said = json.loads(request.content)
    assert (said["event"], said["sweep"]["id"]) == ("sweep.ended", sweep_id)
    assert (said["sweep"]["status"], said["sweep"]["runs"]["succeeded"]) == ("finished", 2)
    assert said["sweep"]["page"] == f"http://here:8000/sweeps/{sweep_id}"
    time, signed = (part[part.index("=") + 1 :] for part in sign(request).split(","))
    expected = hmac.new(b"secret", f"{time}.".encode() + request.content, hashlib.sha256)
    assert signed == expected.hexdigest()
    found = store.find_sweep(sweep_id)
    assert found is not None
    assert (found.webhook_tries, found.webhook_problem) == (0, "")
    assert found.webhook_delivered_at is not None


def sign(request: httpx2.Request) -> str:
    return str(request.headers["D3PG-Signature"])


@pytest.mark.parametrize("failure", [500, 404, 302, httpx2.ConnectTimeout("too slow")])
def test_what_was_not_received_is_told_again(
    store: Store, telling: Telling, failure: int | Exception
) -> None:
    sweep_id = submitted(store)
    train(store)
    receiver = Receiver(failure, failure, 200)
    webhooks = telling(receiver)
    for tries in (1, 2):
        webhooks.work()
        webhooks.work()  # it waits
        found = store.find_sweep(sweep_id)
        assert found is not None
        assert (found.webhook_tries, len(receiver.heard)) == (tries, tries)
        assert found.webhook_problem
        now_due(store)
    webhooks.work()
    now_due(store)
    webhooks.work()
    assert len(receiver.heard) == 3
    assert len({request.headers["D3PG-Delivery"] for request in receiver.heard}) == 1
    assert {str(request.url) for request in receiver.heard} == {URL}  # no redirect is followed


def test_it_is_given_up_after_many_tries(store: Store, telling: Telling) -> None:
    sweep_id = submitted(store)
    train(store)
    receiver = Receiver(500)
    webhooks = telling(receiver)
    for _ in range(MOST_TRIES + 3):
        webhooks.work()
        now_due(store)
    assert len(receiver.heard) == MOST_TRIES
    found = store.find_sweep(sweep_id)
    assert found is not None
    assert found.webhook_problem == "it answered 500"


def test_a_sweep_that_ends_again_is_told_again(store: Store, telling: Telling) -> None:
    sweep_id = submitted(store)
    train(store)
    receiver = Receiver(200)
    webhooks = telling(receiver)
    webhooks.work()
    store.add_seeds(sweep_id, REQUEST, [2], lambda _: 1)
    webhooks.work()
    assert len(receiver.heard) == 1
    train(store)
    webhooks.work()
    assert len(receiver.heard) == 2
    assert json.loads(receiver.heard[1].content)["sweep"]["runs"]["succeeded"] == 3


def test_a_host_that_may_not_be_told_is_not_asked(store: Store, telling: Telling) -> None:
    sweep_id = submitted(store)
    train(store)
    receiver = Receiver(200)
    telling(receiver, ("hooks.example.org",)).work()
    assert receiver.heard == []
    found = store.find_sweep(sweep_id)
    assert found is not None
    assert "D3PG_WEBHOOK_HOSTS" in found.webhook_problem


@pytest.mark.parametrize(
    ("url", "hosts", "is_refused"),
    [
        ("http://127.0.0.1/x", (), False),
        ("http://169.254.169.254/latest", (), True),
        ("http://[fe80::1]/x", (), True),
        ("http://[::ffff:169.254.169.254]/x", (), True),
        ("http://169.254.169.254/latest", ("169.254.169.254",), False),
        ("https://HOOKS.example.org/x", ("hooks.example.org",), False),
        ("https://hooks.example.org.evil.org/x", ("hooks.example.org",), True),
    ],
)
def test_where_webhooks_may_lead(url: str, hosts: tuple[str, ...], is_refused: bool) -> None:
    assert bool(refusal(url, hosts)) == is_refused


@pytest.mark.parametrize(
    "text", ["", "x", "ftp://a/b", "file:///etc/passwd", "http://", "http://a:b@c/d", "http://a:x/"]
)
def test_what_is_no_webhook(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        webhook_url(text)
