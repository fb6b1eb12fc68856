"""The application as a whole: what it loads, what it documents, how it fails."""

import subprocess
import sys
from pathlib import Path

import pytest
from fastapi import FastAPI
from sqlalchemy.exc import OperationalError
from starlette.testclient import TestClient

from service.store.store import Store
from tests.service.conftest import BASE_URL, TOKEN


def test_it_loads_neither_torch_nor_ray() -> None:
    code = (
        "import sys, service.api.app, service.api.routes.sweeps\n"
        "print(*sorted({'torch', 'ray'} & {name.partition('.')[0] for name in sys.modules}))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_the_documentation_asks_nothing_of_other_sites(client: TestClient) -> None:
    page = client.get("/api/v1/docs")
    assert page.status_code == 200
    assert "http" not in page.text.replace("http-equiv", "")
    assert "sha256-" in page.headers["content-security-policy"]
    for asset in ("swagger-ui-bundle.js", "swagger-ui.css"):
        assert client.get(f"/api/v1/docs/assets/{asset}").status_code == 200


def test_every_operation_is_described(client: TestClient) -> None:
    document = client.get("/api/v1/openapi.json").json()
    operations = [
        (path, operation)
        for path, methods in document["paths"].items()
        for operation in methods.values()
    ]
    assert len(operations) >= 15
    names = [operation["operationId"] for _, operation in operations]
    assert len(set(names)) == len(names)
    for path, operation in operations:
        assert operation["description"], path
        assert operation["tags"], path
    for schema in ("SweepRequest", "SweepAnswer", "RunAnswer", "CurvesAnswer"):
        assert document["components"]["schemas"][schema]["examples"], schema


def test_examples_are_valid(client: TestClient) -> None:
    document = client.get("/api/v1/openapi.json").json()
    example = document["components"]["schemas"]["SweepRequest"]["examples"][0]
    answer = client.post("/api/v1/sweeps?dry_run=true", json=example)
    assert answer.status_code == 200, answer.text
    assert answer.json()["runs"]["total"] == 48


def test_an_error_of_ours_tells_nothing_but_where_to_look(
    app: FastAPI, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("the secret of the inside")

    monkeypatch.setattr(store, "list_sweeps", fail)
    client = TestClient(
        app,
        base_url=BASE_URL,
        headers={"Authorization": f"Bearer {TOKEN}"},
        raise_server_exceptions=False,
    )
    response = client.get("/api/v1/sweeps")
    assert response.status_code == 500
    assert response.headers["content-type"] == "application/problem+json"
    assert "secret" not in response.text
    assert response.json()["request_id"] in response.json()["detail"]


def test_a_database_that_is_away_is_no_error_of_ours(
    client: TestClient, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OperationalError("SELECT 1", {}, Exception(), connection_invalidated=True)

    monkeypatch.setattr(store, "list_sweeps", fail)
    response = client.get("/api/v1/sweeps")
    assert response.status_code == 503
    assert int(response.headers["retry-after"]) > 0
    assert response.json()["type"] == "database-unreachable"
    assert "goes on by itself" in response.json()["detail"]


def test_what_has_no_route_is_a_problem(client: TestClient) -> None:
    for method, path, status in (("GET", "/nowhere", 404), ("DELETE", "/api/v1/sweeps", 405)):
        response = client.request(method, path)
        assert response.status_code == status
        assert response.headers["content-type"] == "application/problem+json"
        assert response.json()["status"] == status


def test_a_request_id_comes_back(client: TestClient) -> None:
    sent = "0123456789abcdef0123456789abcdef"
    response = client.get("/healthz", headers={"X-Request-ID": sent})
    assert response.headers["x-request-id"] == sent
    forged = client.get("/healthz", headers={"X-Request-ID": "x" * 5000})
    assert len(forged.headers["x-request-id"]) == 32


def test_the_data_directory_is_not_served(client: TestClient, tmp_path: Path) -> None:
    (tmp_path / "token").write_text("secret")
    for path in ("/static/../token", "/static/%2e%2e/token", "/token", "/api/v1/docs/assets/../x"):
        assert "secret" not in client.get(path).text
