"""Users: their tokens, and what they may do with the sweeps of others."""

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.model.caller import Scope
from service.store.store import Store
from tests.service.api.routes.people.conftest import As
from tests.service.conftest import SWEEP, TOKEN, client_of

USERS, SWEEPS = "/api/v1/users", "/api/v1/sweeps"


def test_a_user_is_made_listed_and_revoked(app: FastAPI, client: TestClient) -> None:
    made = client.post(USERS, json={"name": "ann", "scope": "submit"})
    assert made.status_code == 201
    token = made.json().pop("token")
    ann = client_of(app, token)
    assert ann.get(SWEEPS).status_code == 200
    [listed] = client.get(USERS).json()
    assert listed["name"] == "ann"
    assert listed["revoked_at"] is None
    assert "token" not in listed
    assert client.delete(f"{USERS}/ann").json()["revoked_at"] is not None
    assert ann.get(SWEEPS).status_code == 401
    assert client.delete(f"{USERS}/nobody").status_code == 404


def test_only_the_hash_of_a_token_is_kept(app: FastAPI, client: TestClient, store: Store) -> None:
    token = client.post(USERS, json={"name": "ann", "scope": "read"}).json()["token"]
    browser = client_of(app, token="")
    browser.post("/signin", data={"token": token})
    [cookie] = browser.cookies.values()
    kept = f"{store.users()} {store.sessions()}"
    for secret in (token, cookie, TOKEN):
        assert len(secret) >= 16
        assert secret not in kept


def test_a_name_is_one_user_s(app: FastAPI, client: TestClient) -> None:
    first = client.post(USERS, json={"name": "ann", "scope": "submit"}).json()["token"]
    again = client.post(USERS, json={"name": "ann", "scope": "admin"})
    assert again.status_code == 409
    assert "revoke it first" in again.json()["detail"]
    sweep = client_of(app, first).post(SWEEPS, json=SWEEP).json()["id"]
    client.delete(f"{USERS}/ann")
    second = client.post(USERS, json={"name": "ann", "scope": "submit"}).json()["token"]
    assert client_of(app, first).get(SWEEPS).status_code == 401
    assert client_of(app, second).post(f"{SWEEPS}/{sweep}/cancel").status_code == 202


@pytest.mark.parametrize(
    ("name", "scope", "says"),
    [
        ("admin", "read", "the service's own token"),
        ("Ann", "read", "pattern"),
        ("", "read", "pattern"),
        ("a/b", "read", "pattern"),
        ("a" * 33, "read", "pattern"),
        ("ann", "everything", "'metrics', 'read', 'submit' or 'admin'"),
    ],
)
def test_what_is_no_user_is_refused(client: TestClient, name: str, scope: str, says: str) -> None:
    response = client.post(USERS, json={"name": name, "scope": scope})
    assert response.status_code == 422
    assert says in response.text


def test_a_sweep_is_of_whoever_submitted_it(client: TestClient, called: As) -> None:
    ann = called("ann", Scope.SUBMIT)
    of_ann, of_admin = (each.post(SWEEPS, json=SWEEP).json() for each in (ann, client))
    assert (of_ann["owner"], of_admin["owner"]) == ("ann", "admin")
    listed = client.get(SWEEPS, params={"owner": "ann"}).json()["items"]
    assert [(each["id"], each["owner"]) for each in listed] == [(of_ann["id"], "ann")]


CHANGES = [
    ("PATCH", f"{SWEEPS}/{{sweep}}", {"name": "mine now"}),
    ("POST", f"{SWEEPS}/{{sweep}}/pause", None),
    ("POST", f"{SWEEPS}/{{sweep}}/runs", {"seeds": [99]}),
    ("POST", f"{SWEEPS}/{{sweep}}/cancel", None),
    ("POST", "/api/v1/runs/{sweep}-0/pause", None),
    ("DELETE", f"{SWEEPS}/{{sweep}}", None),
]


@pytest.mark.parametrize(("method", "path", "body"), CHANGES)
def test_others_sweeps_are_not_changed(
    client: TestClient, called: As, method: str, path: str, body: object
) -> None:
    sweep = client.post(SWEEPS, json=SWEEP).json()
    if method == "DELETE":
        client.post(f"{SWEEPS}/{sweep['id']}/cancel")
    before = client.get(f"{SWEEPS}/{sweep['id']}").json()
    ann = called("ann", Scope.SUBMIT)
    asked = path.format(sweep=sweep["id"])
    response = ann.request(method, asked, json=body)
    assert response.status_code == 403
    assert f"Sweep {sweep['id']} is of admin" in response.json()["detail"]
    assert client.get(f"{SWEEPS}/{sweep['id']}").json() == before
    assert called("root", Scope.ADMIN).request(method, asked, json=body).status_code < 300
    assert ann.request(method, path.format(sweep="0" * 12), json=body).status_code == 404


def test_of_many_those_of_others_are_refused(client: TestClient, called: As) -> None:
    ann = called("ann", Scope.SUBMIT)
    own, other = (each.post(SWEEPS, json=SWEEP).json()["id"] for each in (ann, client))
    asked = {
        "move": "cancel",
        "ids": [own, other, f"{other}-1", f"{own}-0", "sweep \u00e9", "0" * 12],
    }
    answer = ann.post("/api/v1/moves", json=asked).json()
    assert answer["moved"] == [own, f"{own}-0"]
    reasons = {each["id"]: each["reason"] for each in answer["refused"]}
    assert "is of admin" in reasons[other]
    assert "is of admin" in reasons[f"{other}-1"]
    assert client.get(f"{SWEEPS}/{other}").json()["status"] == "queued"


def test_a_key_of_submission_is_one_s_own(client: TestClient, called: As) -> None:
    key = {"Idempotency-Key": "first"}
    client.post(SWEEPS, json=SWEEP, headers=key)
    refused = called("ann", Scope.SUBMIT).post(SWEEPS, json=SWEEP, headers=key)
    assert refused.status_code == 422
    assert "admin has submitted a sweep under this key" in refused.json()["detail"]


def test_prometheus_reads_metrics_alone(app: FastAPI, called: As) -> None:
    prometheus = called("prometheus", Scope.METRICS)
    assert prometheus.get("/metrics").status_code == 200
    for path in (SWEEPS, "/readyz", "/", "/api/v1/events", "/api/v1/openapi.json"):
        assert prometheus.get(path).status_code == 403
    token = prometheus.headers["authorization"].removeprefix("Bearer ")
    browser = client_of(app, token="")
    assert browser.post("/signin", data={"token": token}).status_code == 401


def test_a_session_ends_with_its_user(app: FastAPI, client: TestClient, called: As) -> None:
    token = called("ann", Scope.SUBMIT).headers["authorization"].removeprefix("Bearer ")
    browser = client_of(app, token="")
    browser.post("/signin", data={"token": token})
    assert browser.get(SWEEPS).status_code == 200
    assert '<span class="muted">ann</span>' in browser.get("/").text
    client.delete(f"{USERS}/ann")
    assert browser.get(SWEEPS).status_code == 401
    assert app.state.store.sessions() == []


def test_one_sees_one_s_own_sessions(app: FastAPI, client: TestClient, called: As) -> None:
    ann = called("ann", Scope.READ)
    for token in (TOKEN, ann.headers["authorization"].removeprefix("Bearer ")):
        client_of(app, token="").post("/signin", data={"token": token})
    [own] = ann.get("/api/v1/sessions").json()
    assert own["name"] == "ann"
    all_of_them = client.get("/api/v1/sessions").json()
    assert {each["name"] for each in all_of_them} == {"admin", "ann"}
    [others] = [each["id"] for each in all_of_them if each["name"] == "admin"]
    assert ann.delete(f"/api/v1/sessions/{others}").status_code == 404
