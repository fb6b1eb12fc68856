"""Every route times every scope: what a caller may do follows from what the route says, for all.

`WHO_MAY` is the contract, written by hand: a route that is added stands in no line of it, and this
test fails until somebody has decided who may call it.
"""

from collections.abc import Iterator
from typing import Any

import pytest
from fastapi import APIRouter, FastAPI
from fastapi.routing import iter_route_contexts
from starlette.responses import PlainTextResponse
from starlette.routing import Mount, Route
from starlette.testclient import TestClient

from service.api.access import authority
from service.api.access.authority import MAY_READ, UndeclaredScopeError, refuse_undeclared
from service.api.access.guard import PUBLIC_PREFIX, is_public
from service.model.caller import Scope
from tests.service.api.access.test_guard import FOREIGN_HOSTS, FOREIGN_PAGES
from tests.service.conftest import SWEEP, app_in, client_of

SHARED, OTHER = "shared", "other"
SWEEP_PATHS = ("/api/v1/sweeps/{sweep_id}", "/api/v1/runs/{run_id}", "/sweeps/{", "/runs/{")
CALLERS = (*Scope, SHARED)

OPEN_ROUTES = {("GET", "/healthz"), ("GET", "/signin"), ("POST", "/signin")}
TO_METRICS = {("GET", "/metrics")}
TO_SHARED = {
    ("GET", "/api/v1/sweeps"),
    ("GET", "/api/v1/events"),
    ("GET", "/api/v1/catalogue"),
    ("GET", "/api/v1/environments/{environment:path}/picture"),
    ("GET", "/compare"),
    ("GET", "/favicon.ico"),
    ("POST", "/signout"),
}
TO_ADMINISTRATORS = {
    ("GET", "/api/v1/users"),
    ("POST", "/api/v1/users"),
    ("DELETE", "/api/v1/users/{name}"),
}
READ_BY_POST = {
    ("POST", "/api/v1/rollouts"),
    ("POST", "/api/v1/sign-in-links"),
    ("DELETE", "/api/v1/sessions/{session_id}"),  # one's own
    ("DELETE", "/api/v1/shares/{share_id}"),  # one's own
}
"""What changes nothing, or nothing that is of anybody else."""


def routes(app: FastAPI) -> Iterator[tuple[str, str]]:
    """Every method of every route. What is mounted is public, as another test says."""
    for route in iter_route_contexts(app.routes):
        if not isinstance(route.original_route, Mount):
            for method in route.methods or ():
                yield method, route.path or ""


def least_scope(method: str, path: str) -> Scope | None:
    """Who may call, by the contract; None: everybody."""
    if (method, path) in OPEN_ROUTES:
        return None
    if (method, path) in TO_METRICS:
        return Scope.METRICS
    if (method, path) in TO_ADMINISTRATORS:
        return Scope.ADMIN
    is_read = method == "GET" or (method, path) in READ_BY_POST | TO_SHARED
    return Scope.READ if is_read else Scope.SUBMIT


def is_shared(method: str, path: str) -> bool:
    """Whether somebody who came by a link may call it."""
    if (method, path) in OPEN_ROUTES | TO_SHARED:
        return True
    return method == "GET" and path.startswith(SWEEP_PATHS)


@pytest.fixture(scope="module")
def peopled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FastAPI]:
    """A service with sweeps and callers of every scope."""
    with app_in(tmp_path_factory.mktemp("peopled")) as app:
        yield app


@pytest.fixture(scope="module")
def administrator(peopled: FastAPI) -> TestClient:
    return client_of(peopled)


@pytest.fixture(scope="module")
def there(peopled: FastAPI, administrator: TestClient) -> dict[str, str]:
    """The ids of two sweeps of the administrator; one is shared."""
    made = [administrator.post("/api/v1/sweeps", json=SWEEP).json()["id"] for _ in range(2)]
    return {SHARED: made[0], OTHER: made[1]}


@pytest.fixture(scope="module")
def callers(peopled: FastAPI, there: dict[str, str]) -> Iterator[dict[str, TestClient]]:
    """A client of each scope, one that came by a link, and a stranger."""
    register = peopled.state.register
    tokens = {scope.value: register.add_user(f"every-{scope.value}", scope) for scope in Scope}
    share, tokens[SHARED] = register.add_share((there[SHARED],), "/", 1, "admin")
    yield {name: client_of(peopled, token) for name, token in tokens.items()}
    register.remove_share(share.id)
    for scope in Scope:
        register.revoke_user(f"every-{scope.value}")


def filled(path: str, sweep: str) -> str:
    """A path with a sweep and its first run; other names are of nothing."""
    given = {"sweep_id": sweep, "run_id": f"{sweep}-0"}
    for name in ("number", "form", "figure", "share_id", "session_id", "name", "environment"):
        given[name] = "none"
    return path.replace(":path}", "}").format(**given)


def status(client: TestClient, method: str, path: str, headers: Any = None) -> int:
    """Ask as little as possible; a stream that opens is closed at once."""
    if path.endswith("/events"):
        path += "?after=not-a-number"  # which is refused after the caller was let in
    return client.request(method, path, headers=headers).status_code


def test_every_route_times_every_scope(
    peopled: FastAPI, callers: dict[str, TestClient], there: dict[str, str]
) -> None:
    wrong, asked = [], 0
    deletion = ("DELETE", "/api/v1/sweeps/{sweep_id}")
    for method, template in sorted(routes(peopled), key=lambda each: each == deletion):
        path, needed = filled(template, there[SHARED]), least_scope(method, template)
        for scope in Scope:
            found, asked = status(callers[scope.value], method, path), asked + 1
            may = needed is None or scope.includes(needed)
            if is_change(needed, template) and scope is Scope.SUBMIT:
                may = False  # it is the administrator's sweep
            if (found == 403) is may or (found == 401 and needed is not None):
                wrong.append((scope.value, method, path, found))
    assert wrong == []
    assert asked > 200


def is_change(needed: Scope | None, template: str) -> bool:
    return needed is Scope.SUBMIT and template.startswith(SWEEP_PATHS)


def test_every_route_times_a_shared_link(
    peopled: FastAPI, callers: dict[str, TestClient], there: dict[str, str]
) -> None:
    wrong = []
    for method, template in routes(peopled):
        for which in (SHARED, OTHER):
            path = filled(template, there[which])
            found = status(callers[SHARED], method, path)
            is_of_sweep = path != template and template.startswith(SWEEP_PATHS)
            may = is_shared(method, template) and (which == SHARED or not is_of_sweep)
            if (found == 403) is may:
                wrong.append((method, path, found))
    assert wrong == []


@pytest.mark.parametrize("caller", CALLERS)
def test_no_scope_makes_up_for_a_foreign_host_or_page(
    peopled: FastAPI, callers: dict[str, TestClient], there: dict[str, str], caller: str
) -> None:
    """Every route, of every caller, from every foreign host and page: 403 before anything else."""
    foreign = [{"Host": host} for host in FOREIGN_HOSTS] + list(FOREIGN_PAGES)
    for method, template in routes(peopled):
        path = filled(template, there[SHARED])
        for headers in foreign:
            response = callers[caller].request(method, path, headers=headers)
            assert response.status_code == 403, (method, path, headers)
            assert "service" in response.json()["detail"]


def test_no_route_is_missed(peopled: FastAPI) -> None:
    found = set(routes(peopled))
    known = OPEN_ROUTES | TO_METRICS | TO_SHARED | TO_ADMINISTRATORS | READ_BY_POST
    assert known <= found
    assert len(found) > 60


def test_what_is_mounted_is_public(peopled: FastAPI) -> None:
    mounted = [
        route.path
        for route in iter_route_contexts(peopled.routes)
        if isinstance(route.original_route, Mount)
    ]
    assert mounted == [f"{PUBLIC_PREFIX}{{version}}"]
    assert all(is_public(f"{path}/") for path in mounted)


def answer() -> str:
    return "something"


def test_a_route_that_says_nothing_keeps_the_service_from_starting() -> None:
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)
    silent, spoken, twice = APIRouter(), APIRouter(dependencies=[MAY_READ]), APIRouter()
    silent.get("/silent")(answer)
    spoken.get("/spoken")(answer)
    twice.get("/twice", dependencies=[MAY_READ, authority.MAY_SUBMIT])(answer)
    for router in (silent, spoken, twice):
        app.include_router(router)
    app.routes.append(Route("/plain", lambda request: PlainTextResponse("")))
    app.mount("/mounted", FastAPI())
    with pytest.raises(UndeclaredScopeError, match="/mounted, /plain, /silent, /twice: these"):
        refuse_undeclared(app)


def test_the_document_says_who_may(administrator: TestClient) -> None:
    document = administrator.get("/api/v1/openapi.json").json()
    said = document["paths"]["/api/v1/sweeps/{sweep_id}/cancel"]["post"]["security"]
    assert said == [{"token": ["submit"]}]
    assert document["components"]["securitySchemes"]["token"]["scheme"] == "bearer"
    assert "security" not in document["paths"]["/healthz"]["get"]
