"""Bodies above the limit are refused, announced or not, before they are kept."""

from collections.abc import Iterator

import pytest
from starlette.testclient import TestClient

from service.api.body_limit import MAX_BODY_BYTES


def chunks(total: int) -> Iterator[bytes]:
    for _ in range(0, total, 65536):
        yield b" " * 65536


def test_announced(idle_client: TestClient) -> None:
    response = idle_client.post("/api/v1/sweeps", content=b" " * (MAX_BODY_BYTES + 1))
    assert response.status_code == 413
    assert response.headers["content-type"] == "application/problem+json"
    assert str(MAX_BODY_BYTES) in response.json()["detail"]
    assert response.json()["request_id"] == response.headers["x-request-id"]


def test_announced_in_more_digits_than_python_reads(idle_client: TestClient) -> None:
    response = idle_client.post(
        "/api/v1/sweeps", content=b"{}", headers={"Content-Length": "9" * 5000}
    )
    assert response.status_code == 413


def test_streamed(idle_client: TestClient) -> None:
    response = idle_client.post(
        "/api/v1/sweeps",
        content=chunks(2 * MAX_BODY_BYTES),
        headers={"Content-Type": "application/json"},
    )
    assert response.status_code == 413
    assert str(MAX_BODY_BYTES) in response.json()["detail"]


@pytest.mark.parametrize("length", ["-1", "x", "1e9", "+2"])
def test_a_nonsense_length_announces_nothing(idle_client: TestClient, length: str) -> None:
    response = idle_client.post("/api/v1/sweeps", content=b"{}", headers={"Content-Length": length})
    assert response.status_code == 422


def test_at_the_limit_the_content_decides(idle_client: TestClient) -> None:
    body = b"{}" + b" " * (MAX_BODY_BYTES - 2)
    response = idle_client.post(
        "/api/v1/sweeps", content=body, headers={"Content-Type": "application/json"}
    )
    assert response.status_code == 422
