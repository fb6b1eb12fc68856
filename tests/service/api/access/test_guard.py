"""Nothing is answered to strangers: every route, every method, WebSockets too."""

from collections.abc import Iterator

import pytest
from fastapi import FastAPI
from fastapi.routing import iter_route_contexts
from starlette.routing import Mount
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from service.api.access.guard import PUBLIC_PATHS, PUBLIC_PREFIX, host_name, is_public
from tests.service.conftest import TOKEN

METHODS = ("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS")
FOREIGN_HOSTS = (
    "evil.example",
    "evil.example:8000",
    "localhost.evil.example",
    "127.0.0.1.evil.example",
    "127.0.0.1:80@evil.example",
    "127.0.0.1/",
    "127.0.0.1:port",
    "",
)
FOREIGN_PAGES = (
    {"Origin": "https://evil.example"},
    {"Origin": "http://127.0.0.1:8001"},
    {"Origin": "null"},
    {"Sec-Fetch-Site": "cross-site"},
    {"Sec-Fetch-Site": "same-site"},
)


def paths(app: FastAPI) -> Iterator[str]:
    """Every path the application has a route for, and some it has none for."""
    for route in iter_route_contexts(app.routes):
        path = route.path or ""
        if isinstance(route.original_route, Mount):
            path += "/x"
        yield path.replace("{sweep_id}", "0" * 12).replace("{run_id}", f"{'0' * 12}-0")
    yield from ("/", "/nowhere", "/api/v1", "//healthz", "/healthz/", "/static", "/staticx")


def test_enumeration_sees_the_routes(idle_app: FastAPI) -> None:
    found = set(paths(idle_app))
    assert {"/healthz", "/signin", "/readyz", "/api/v1/sweeps", "/api/v1/docs"} <= found
    assert len(found) > 20


def test_public_is_what_the_contract_says(idle_app: FastAPI) -> None:
    public = {path for path in paths(idle_app) if is_public(path)}
    assert {"/healthz", "/signin"} == PUBLIC_PATHS
    assert {path for path in public if not path.startswith(PUBLIC_PREFIX)} == PUBLIC_PATHS


def test_no_route_answers_without_token(idle_app: FastAPI, idle_stranger: TestClient) -> None:
    for path in paths(idle_app):
        if is_public(path):
            continue
        for method in METHODS:
            assert idle_stranger.request(method, path).status_code == 401, (method, path)


@pytest.mark.parametrize(
    "headers",
    [
        {"Authorization": "Bearer "},
        {"Authorization": "Bearer x"},
        {"Authorization": f"Bearer {TOKEN}x"},
        {"Authorization": f"Basic {TOKEN}"},
        {"Authorization": TOKEN},
        {"Cookie": f"token={TOKEN}"},
    ],
)
def test_no_route_answers_a_wrong_token(idle_stranger: TestClient, headers: dict[str, str]) -> None:
    response = idle_stranger.get("/api/v1/sweeps", headers=headers)
    assert response.status_code == 401
    assert response.headers["www-authenticate"] == "Bearer"


@pytest.mark.parametrize("host", FOREIGN_HOSTS)
def test_no_route_answers_a_foreign_host(
    idle_app: FastAPI, idle_client: TestClient, host: str
) -> None:
    for path in paths(idle_app):
        response = idle_client.get(path, headers={"Host": host})
        assert response.status_code == 403, path
        assert "D3PG_ALLOW_HOST" in response.text


@pytest.mark.parametrize("headers", FOREIGN_PAGES)
def test_no_route_answers_a_foreign_page(
    idle_app: FastAPI, idle_client: TestClient, headers: dict[str, str]
) -> None:
    for path in paths(idle_app):
        for method in METHODS:
            assert idle_client.request(method, path, headers=headers).status_code == 403, (
                method,
                path,
            )


def test_a_link_from_another_site_opens_a_page_but_changes_nothing(idle_client: TestClient) -> None:
    link = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}
    assert idle_client.get("/api/v1/sweeps", headers=link).status_code == 200
    assert idle_client.post("/api/v1/sweeps", headers=link, json={}).status_code == 403


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://127.0.0.1:8000", "Sec-Fetch-Site": "same-origin"},
        {"Sec-Fetch-Site": "none"},
        {"Host": "localhost:1234", "Origin": "http://localhost:1234"},
        {"Host": "LOCALHOST"},
        {"Host": "[::1]:8000"},
    ],
)
def test_our_own_pages_are_answered(idle_client: TestClient, headers: dict[str, str]) -> None:
    assert idle_client.get("/api/v1/sweeps", headers=headers).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [{}, {"Host": "evil.example"}, {"Origin": "https://evil.example"}],
)
def test_no_websocket_is_accepted(idle_stranger: TestClient, headers: dict[str, str]) -> None:
    with (
        pytest.raises(WebSocketDisconnect) as refusal,
        idle_stranger.websocket_connect("/api/v1/events", headers=headers),
    ):
        pass
    assert refusal.value.code == 1008


def test_people_get_a_page_and_programs_a_problem(idle_stranger: TestClient) -> None:
    page = idle_stranger.get("/", headers={"Accept": "text/html,*/*"})
    assert page.headers["content-type"].startswith("text/html")
    assert "sign-in link" in page.text
    problem = idle_stranger.get("/")
    assert problem.headers["content-type"] == "application/problem+json"
    assert "sign-in link" in problem.json()["detail"]


def test_every_answer_has_the_security_headers(
    idle_client: TestClient, idle_stranger: TestClient
) -> None:
    for response in (
        idle_client.get("/api/v1/sweeps"),
        idle_stranger.get("/"),
        idle_client.get("/nowhere"),
    ):
        policy = response.headers["content-security-policy"]
        assert "default-src 'self'" in policy
        assert "unsafe-inline" not in policy
        assert "frame-ancestors 'none'" in policy
        assert response.headers["x-content-type-options"] == "nosniff"
        assert "access-control-allow-origin" not in response.headers


@pytest.mark.parametrize(
    ("host", "name"),
    [
        ("LocalHost:80", "localhost"),
        ("[::1]:8000", "[::1]"),
        ("[::1]", "[::1]"),
        ("a@b", ""),
        ("a:99999", ""),
        ("a/b", ""),
        ("a?b", ""),
        ("[::1", ""),
        ("a b", "a b"),
    ],
)
def test_host_name(host: str, name: str) -> None:
    assert host_name(host) == name
