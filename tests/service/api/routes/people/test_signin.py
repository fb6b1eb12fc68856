"""Signing a browser in, by a code in a link or a token in a form, and out."""

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.api.access.links import signin_path
from service.api.access.register import CODE_SECONDS, SESSION_SECONDS, Register
from tests.service.conftest import TOKEN, client_of

OUTSIDE = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}


class Clock:
    """A time that a test sets."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(app: FastAPI) -> Clock:
    """What the register goes by."""
    app.state.register._clock = clock = Clock()
    return clock


@pytest.fixture
def register(app: FastAPI) -> Register:
    register: Register = app.state.register
    return register


@pytest.fixture
def browser(app: FastAPI) -> TestClient:
    """A client without a token, which keeps cookies."""
    return client_of(app, token="")


def is_signed_in(browser: TestClient) -> bool:
    status = browser.get("/api/v1/sweeps").status_code
    assert status in {200, 401}
    return status == 200


def test_the_link_sets_a_cookie_and_leaves_the_url(browser: TestClient, register: Register) -> None:
    response = browser.get(signin_path(register.new_code()))
    assert response.status_code == 303
    assert response.headers["location"] == "/"
    cookie = response.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert "Path=/;" in cookie
    assert "Secure" not in cookie
    assert TOKEN not in cookie
    assert response.headers["cache-control"] == "no-store"
    assert response.headers["referrer-policy"] == "no-referrer"
    assert is_signed_in(browser)


def test_a_link_signs_one_browser_in(app: FastAPI, browser: TestClient, register: Register) -> None:
    link = signin_path(register.new_code())
    assert browser.get(link).status_code == 303
    another = client_of(app, token="")
    response = another.get(link)
    assert response.status_code == 401
    assert "`d3pg signin` prints a new one" in response.json()["detail"]
    assert "set-cookie" not in response.headers
    assert not is_signed_in(another)


def test_a_used_link_leads_on_who_is_signed_in(browser: TestClient, register: Register) -> None:
    link = signin_path(register.new_code(), "/catalogue")
    browser.get(link)
    again = browser.get(link)
    assert again.headers["location"] == "/catalogue"
    assert "set-cookie" not in again.headers


def test_a_link_is_good_for_ten_minutes(
    browser: TestClient, register: Register, clock: Clock
) -> None:
    link = signin_path(register.new_code())
    clock.now += CODE_SECONDS
    assert browser.get(link).status_code == 401
    assert not is_signed_in(browser)


def test_no_token_stands_in_an_address(browser: TestClient) -> None:
    """Addresses go into histories and logs; a token there signs nobody in."""
    for query in (f"?token={TOKEN}", f"?code={TOKEN}"):
        response = browser.get(f"/signin{query}")
        assert response.status_code == 401
        assert "set-cookie" not in response.headers
    page = browser.get("/signin", headers={"Accept": "text/html"}).text
    assert '<form id="signin" action="/signin" method="post">' in page


def test_a_token_in_the_form_signs_in(browser: TestClient) -> None:
    response = browser.post("/signin", data={"token": f" {TOKEN}\n", "next": "/sweeps/x?y=1"})
    assert response.status_code == 303
    assert response.headers["location"] == "/sweeps/x?y=1"
    assert is_signed_in(browser)


@pytest.mark.parametrize("token", ["", "wrong", f"{TOKEN}x", "\udcff"])
def test_a_wrong_token_sets_nothing(browser: TestClient, token: str) -> None:
    body = b"token=" + token.encode(errors="surrogateescape")
    response = browser.post("/signin", content=body)
    assert response.status_code == 401
    assert "set-cookie" not in response.headers
    assert browser.post("/signin", content=b"\xff=%%%").status_code == 401


def test_a_bad_bearer_is_not_made_good_by_a_cookie(browser: TestClient) -> None:
    browser.post("/signin", data={"token": TOKEN})
    headers = {"Authorization": "Bearer wrong"}
    assert browser.get("/api/v1/sweeps", headers=headers).status_code == 401


def test_what_the_cookie_holds_is_no_token(browser: TestClient) -> None:
    browser.post("/signin", data={"token": TOKEN})
    [held] = browser.cookies.values()
    browser.cookies.clear()
    headers = {"Authorization": f"Bearer {held}"}
    assert browser.get("/api/v1/sweeps", headers=headers).status_code == 401


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
    browser: TestClient, register: Register, target: str, goes_to: str
) -> None:
    asked = {"code": register.new_code(), "next": target}
    assert browser.get("/signin", params=asked).headers["location"] == goes_to
    form = {"token": TOKEN, "next": target}
    assert browser.post("/signin", data=form).headers["location"] == goes_to


def test_followed_from_another_site_a_page_of_ours_goes_on(
    browser: TestClient, register: Register
) -> None:
    """A redirect would not carry the SameSite=Strict cookie that it has just set."""
    code = register.new_code()
    asked = {"code": code, "next": '/sweeps/"><script>'}
    response = browser.get("/signin", params=asked, headers=OUTSIDE)
    assert response.status_code == 200
    assert "set-cookie" in response.headers
    assert 'content="0; url=/sweeps/%22%3E%3Cscript%3E"' in response.text
    assert code not in response.text


def test_another_site_cannot_sign_a_browser_in(browser: TestClient) -> None:
    response = browser.post("/signin", data={"token": TOKEN}, headers=OUTSIDE)
    assert response.status_code == 403
    assert "set-cookie" not in response.headers


def test_sessions_end(browser: TestClient, clock: Clock) -> None:
    browser.post("/signin", data={"token": TOKEN})
    clock.now += SESSION_SECONDS - 1
    assert is_signed_in(browser)
    clock.now += 1
    assert not is_signed_in(browser)


def test_signing_out_ends_the_session_of_that_browser(app: FastAPI, browser: TestClient) -> None:
    other = client_of(app, token="")
    for each in (browser, other):
        each.post("/signin", data={"token": TOKEN})
    held = dict(browser.cookies)
    response = browser.post("/signout")
    assert response.status_code == 303
    assert response.headers["location"] == "/signin"
    assert not browser.cookies
    thief = client_of(app, token="")
    thief.cookies.update(held)
    assert not is_signed_in(thief)
    assert is_signed_in(other)


def test_a_session_outlives_the_service_and_ends_with_the_token(
    app: FastAPI, browser: TestClient
) -> None:
    browser.post("/signin", data={"token": TOKEN})
    store = app.state.store
    [secret] = browser.cookies.values()
    again = Register(store, TOKEN).by_cookie(secret)
    assert again is not None
    assert again.name == "admin"
    assert Register(store, "another token of the tests").by_cookie(secret) is None


def test_sessions_are_listed_and_ended_from_elsewhere(
    client: TestClient, browser: TestClient
) -> None:
    browser.post("/signin", data={"token": TOKEN}, headers={"User-Agent": "Firefox"})
    [session] = client.get("/api/v1/sessions").json()
    assert session["name"] == "admin"
    assert session["browser"] == "Firefox"
    assert client.delete(f"/api/v1/sessions/{session['id']}").json() == session
    assert not is_signed_in(browser)
    assert client.delete(f"/api/v1/sessions/{session['id']}").status_code == 404


def test_a_link_of_the_api_signs_in_whoever_asked_for_it(
    client: TestClient, browser: TestClient
) -> None:
    answer = client.post("/api/v1/sign-in-links", json={"page": "/catalogue"})
    assert answer.status_code == 201
    assert answer.json()["link"].startswith("http://127.0.0.1:8000/signin?code=")
    assert browser.get(answer.json()["link"]).headers["location"] == "/catalogue"
    assert is_signed_in(browser)
    refused = client.post("/api/v1/sign-in-links", json={"page": "//evil.example"})
    assert refused.status_code == 422
