"""Signing a browser in by its link."""

import pytest
from starlette.testclient import TestClient

from service.api.access_token import session_cookie
from tests.service.conftest import TOKEN


def test_the_link_sets_a_cookie_and_leaves_the_url(idle_stranger: TestClient) -> None:
    response = idle_stranger.get(f"/signin?token={TOKEN}")
    assert response.status_code == 303
    assert response.headers["location"] == "/"
    name, value = session_cookie(TOKEN)
    cookie = response.headers["set-cookie"]
    assert cookie.startswith(f"{name}={value};")
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert response.headers["cache-control"] == "no-store"
    assert response.headers["referrer-policy"] == "no-referrer"


def test_the_cookie_signs_in(idle_stranger: TestClient) -> None:
    assert idle_stranger.get("/api/v1/sweeps").status_code == 401
    idle_stranger.get(f"/signin?token={TOKEN}")
    assert idle_stranger.get("/api/v1/sweeps").status_code == 200


def test_a_bad_bearer_is_not_made_good_by_a_cookie(idle_stranger: TestClient) -> None:
    idle_stranger.get(f"/signin?token={TOKEN}")
    headers = {"Authorization": "Bearer wrong"}
    assert idle_stranger.get("/api/v1/sweeps", headers=headers).status_code == 401


@pytest.mark.parametrize("query", ["", "?token=", "?token=wrong", f"?token={TOKEN}x"])
def test_a_wrong_link_sets_nothing(idle_stranger: TestClient, query: str) -> None:
    response = idle_stranger.get(f"/signin{query}")
    assert response.status_code == 401
    assert "set-cookie" not in response.headers


@pytest.mark.parametrize(
    ("target", "goes_to"),
    [
        ("/sweeps/3f9a0c51b7de?x=1", "/sweeps/3f9a0c51b7de?x=1"),
        ("https://evil.example", "/"),
        ("//evil.example", "/"),
        ("/\\evil.example", "/"),
        ("/\t/evil.example", "/"),
        ("javascript:alert(1)", "/"),
        ("", "/"),
    ],
)
def test_it_goes_on_to_our_pages_alone(
    idle_stranger: TestClient, target: str, goes_to: str
) -> None:
    response = idle_stranger.get("/signin", params={"token": TOKEN, "next": target})
    assert response.headers["location"] == goes_to


def test_followed_from_another_site_a_page_of_ours_goes_on(idle_stranger: TestClient) -> None:
    """A redirect would not carry the SameSite=Strict cookie that it has just set."""
    response = idle_stranger.get(
        "/signin",
        params={"token": TOKEN, "next": '/sweeps/"><script>'},
        headers={"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"},
    )
    assert response.status_code == 200
    assert "set-cookie" in response.headers
    assert 'content="0; url=/sweeps/%22%3E%3Cscript%3E"' in response.text
    assert TOKEN not in response.text
