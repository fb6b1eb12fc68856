"""Shares: a link opens a sweep or a comparison to anybody, for a time, and nothing else."""

import asyncio
from collections.abc import AsyncGenerator
from typing import Any

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.api.access.register import Register
from service.api.event_feed import Message
from service.api.routes.events import _for_caller
from service.model.caller import Scope
from tests.service.api.routes.people.conftest import As
from tests.service.conftest import SWEEP, client_of

SHARES, SWEEPS = "/api/v1/shares", "/api/v1/sweeps"


@pytest.fixture
def sweeps(client: TestClient) -> list[str]:
    return [client.post(SWEEPS, json=SWEEP).json()["id"] for _ in range(3)]


def token_of(share: dict[str, Any]) -> str:
    token: str = share["link"].partition("#share=")[2]
    return token


def opened(app: FastAPI, share: dict[str, Any]) -> TestClient:
    """A browser that has opened the link."""
    browser = client_of(app, token="")
    response = browser.post("/signin", data={"token": token_of(share)})
    assert response.headers["location"] == share["page"]
    return browser


def test_a_link_opens_a_sweep_and_nothing_else(
    app: FastAPI, client: TestClient, sweeps: list[str]
) -> None:
    shared, other, _ = sweeps
    made = client.post(SHARES, json={"sweeps": [shared]})
    assert made.status_code == 201
    assert made.json()["link"].startswith("http://127.0.0.1:8000/signin#share=")
    browser = opened(app, made.json())
    for path in (f"/sweeps/{shared}", f"/runs/{shared}-0", f"/sweeps/{shared}/runs", "/compare"):
        assert browser.get(path).status_code == 200
    for part in ("", "/runs", "/curves", "/table", "/measurements", "/metrics"):
        assert browser.get(f"{SWEEPS}/{shared}{part}").status_code == 200
        assert browser.get(f"{SWEEPS}/{other}{part}").status_code == 403
    assert browser.get(f"/api/v1/runs/{shared}-0").status_code == 200
    assert browser.get(f"/api/v1/runs/{other}-0").status_code == 403
    for path in ("/", "/workers", "/api/v1/workers", "/metrics", "/readyz", "/api/v1/docs"):
        assert browser.get(path).status_code == 403
    for path in (SHARES, "/api/v1/sessions", "/api/v1/users"):
        assert browser.get(path).status_code == 403
    for path in (f"{SWEEPS}/{shared}/cancel", "/api/v1/sign-in-links", SWEEPS, SHARES):
        assert browser.post(path, json={}).status_code == 403


def test_several_as_one_are_seen_where_each_is(
    app: FastAPI, client: TestClient, sweeps: list[str]
) -> None:
    one, two, other = sweeps
    browser = opened(app, client.post(SHARES, json={"sweeps": [one, two]}).json())
    for part in ("curves", "table", "report"):
        assert browser.get(f"{SWEEPS}/{one}+{two}/{part}").status_code == 200
        for mixed in (f"{one}+{other}", f"{other}+{one}", f"{one}+", "+", f"{one}%2B{other}"):
            assert browser.get(f"{SWEEPS}/{mixed}/{part}").status_code == 403


def test_an_answer_that_somebody_else_has_tells_nothing(
    app: FastAPI, client: TestClient, sweeps: list[str]
) -> None:
    browser = opened(app, client.post(SHARES, json={"sweeps": sweeps[:1]}).json())
    path = f"{SWEEPS}/{sweeps[1]}/curves"
    tag = client.get(path).headers["etag"]
    assert client.get(path, headers={"If-None-Match": tag}).status_code == 304
    assert browser.get(path, headers={"If-None-Match": tag}).status_code == 403


def test_lists_have_what_is_shared(app: FastAPI, client: TestClient, sweeps: list[str]) -> None:
    browser = opened(app, client.post(SHARES, json={"sweeps": sweeps[:2]}).json())
    listed = browser.get(SWEEPS).json()["items"]
    assert [each["id"] for each in listed] == [sweeps[1], sweeps[0]]
    catalogue = browser.get("/api/v1/catalogue").json()
    assert {each["name"] for each in catalogue["environments"]} == {"MassPoint", "Pendulum"}
    assert {each["name"] for each in catalogue["algorithms"]} == {"ddpg", "hybrid-ddpg"}


def test_a_stream_has_what_is_shared_and_ends_with_the_share(
    client: TestClient, app: FastAPI, sweeps: list[str]
) -> None:
    register: Register = app.state.register
    made = client.post(SHARES, json={"sweeps": sweeps[:1]}).json()
    caller = register.by_token(token_of(made))
    assert caller is not None

    async def feed() -> AsyncGenerator[Message, None]:
        yield Message(1, "reload", {"event_id": 1})
        yield Message(2, "sweep", {"sweep_id": sweeps[1]})
        yield Message(3, "sweep", {"sweep_id": sweeps[0]})
        register.remove_share(made["id"])
        yield Message(4, "sweep", {"sweep_id": sweeps[0]})

    async def heard() -> list[int]:
        return [message.id async for message in _for_caller(feed(), caller, register)]

    assert asyncio.run(heard()) == [1, 3]


def test_a_comparison_opens_with_its_view(
    app: FastAPI, client: TestClient, sweeps: list[str]
) -> None:
    made = client.post(SHARES, json={"sweeps": sweeps[:2]}).json()
    assert made["page"] == f"/compare?sweep={sweeps[0]}&sweep={sweeps[1]}"
    page = f"/compare?sweep={sweeps[0]}&band=ci95"
    viewed = client.post(SHARES, json={"sweeps": sweeps[:1], "page": page}).json()
    assert viewed["page"] == page
    opened(app, viewed)


def test_it_expires(
    app: FastAPI, client: TestClient, sweeps: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    made = client.post(SHARES, json={"sweeps": sweeps[:1], "days": 2}).json()
    browser = opened(app, made)
    register: Register = app.state.register
    now = register._clock()
    monkeypatch.setattr(register, "_clock", lambda: now + 2 * 24 * 3600 - 10)
    assert browser.get(f"{SWEEPS}/{sweeps[0]}").status_code == 200
    monkeypatch.setattr(register, "_clock", lambda: now + 2 * 24 * 3600 + 1)
    assert browser.get(f"{SWEEPS}/{sweeps[0]}").status_code == 401
    assert client.get(SHARES).json() == []
    assert (
        client_of(app, token="").post("/signin", data={"token": token_of(made)}).status_code == 401
    )


def test_it_is_listed_and_taken_back(
    app: FastAPI, client: TestClient, called: As, sweeps: list[str]
) -> None:
    ann = called("ann", Scope.SUBMIT)
    made = ann.post(SHARES, json={"sweeps": sweeps[:1]}).json()
    assert made["made_by"] == "ann"
    browser = opened(app, made)
    of_admin = client.post(SHARES, json={"sweeps": sweeps[1:2]}).json()
    [listed] = ann.get(SHARES).json()
    assert listed == {name: value for name, value in made.items() if name != "link"}
    assert {each["id"] for each in client.get(SHARES).json()} == {made["id"], of_admin["id"]}
    assert ann.delete(f"{SHARES}/{of_admin['id']}").status_code == 404
    assert ann.delete(f"{SHARES}/{made['id']}").status_code == 200
    assert browser.get(f"{SWEEPS}/{sweeps[0]}").status_code == 401
    assert ann.get(SHARES).json() == []


def test_shares_go_with_whoever_made_them(
    app: FastAPI, client: TestClient, called: As, sweeps: list[str]
) -> None:
    made = called("ann", Scope.SUBMIT).post(SHARES, json={"sweeps": sweeps[:1]}).json()
    browser = opened(app, made)
    client.delete("/api/v1/users/ann")
    assert browser.get(f"{SWEEPS}/{sweeps[0]}").status_code == 401


def test_a_link_signs_nobody_out(app: FastAPI, client: TestClient, sweeps: list[str]) -> None:
    made = client.post(SHARES, json={"sweeps": sweeps[:1]}).json()
    browser = client_of(app, token="")
    browser.get("/signin", params={"code": app.state.register.new_code()})
    response = browser.post("/signin", data={"token": token_of(made)})
    assert response.headers["location"] == made["page"]
    assert "set-cookie" not in response.headers
    assert browser.get("/api/v1/workers").status_code == 200


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"sweeps": []}, "sweeps"),
        ({"sweeps": ["0" * 12]}, "sweeps[0]"),
        ({"sweeps": ["\x00"]}, "sweeps[0]"),
        ({"sweeps": ["a", "a"]}, "sweeps"),
        ({"sweeps": ["SWEEP"], "days": 0}, "days"),
        ({"sweeps": ["SWEEP"], "days": 366}, "days"),
        ({"sweeps": ["SWEEP"], "page": "https://evil.example"}, "page"),
        ({"sweeps": ["SWEEP"], "page": "//evil.example"}, "page"),
    ],
)
def test_what_cannot_be_shared_is_told(
    client: TestClient, sweeps: list[str], body: dict[str, Any], field: str
) -> None:
    asked = {**body, "sweeps": [sweeps[0] if each == "SWEEP" else each for each in body["sweeps"]]}
    response = client.post(SHARES, json=asked)
    assert response.status_code == 422
    assert [fault["field"] for fault in response.json()["errors"]] == [field]


def test_readers_share_nothing(called: As, sweeps: list[str]) -> None:
    response = called("bob", Scope.READ).post(SHARES, json={"sweeps": sweeps[:1]})
    assert response.status_code == 403
    assert "'submit'" in response.json()["detail"]
