"""What the page says and does when the service goes away, and when it comes back."""

import time

import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import LiveService

pytestmark = pytest.mark.browser


def test_a_lost_connection_is_told_and_caught_up(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    sweep = live.add_sweep()
    live.train(0, 4000)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}?table=Pendulum")
    rows = signed_in.get_by_role("figure", name="Pendulum").locator("tbody tr")
    expect(rows).to_have_count(5)
    expect(signed_in.locator("#connection")).to_have_text("Live")

    live.stop()
    banner = signed_in.locator("#banner")
    expect(banner).to_contain_text("Connection to the service lost at")
    expect(signed_in.locator("#connection")).to_have_text("Offline")
    live.train(4000, 12_000)
    expect(rows).to_have_count(5)

    live.start()
    expect(banner).to_contain_text("Connected again. Everything since")
    expect(rows).to_have_count(15)
    expect(signed_in.locator("#connection")).to_have_text("Live")
    expect(banner).to_be_hidden()
    live.train(12_000, 16_000)
    expect(rows).to_have_count(20)
    assert all("net::ERR" in complaint for complaint in complaints)
    complaints.clear()


def test_a_failing_service_is_told_and_asked_again(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    sweep = live.add_sweep()
    live.train(0, 4000)
    path = f"/api/v1/sweeps/{sweep.id}/curves"
    live.trouble.failing[path] = 500
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    banner = signed_in.locator("#banner")
    expect(banner).to_have_text("The database is on holiday. Trying again …")
    del live.trouble.failing[path]
    expect(signed_in.locator("figure canvas")).to_have_count(2)
    expect(banner).to_be_hidden()
    assert all("500" in complaint for complaint in complaints)
    complaints.clear()


def test_what_the_service_lacks_is_told_while_it_does(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    live.dispatcher.problem = "The disk is full. Free some space there."
    banner = signed_in.locator("#banner")
    expect(banner).to_have_text("The disk is full. Free some space there.")
    live.dispatcher.problem = None
    expect(banner).to_be_hidden()
    assert all("503" in complaint for complaint in complaints)
    complaints.clear()


def test_a_refused_stream_is_opened_again(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    sweep = live.add_sweep()
    path = f"/api/v1/sweeps/{sweep.id}/events"
    live.trouble.failing[path] = 502
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("#connection")).to_have_text("Offline")
    expect(signed_in.get_by_role("heading", level=1)).to_have_text("first look")
    del live.trouble.failing[path]
    expect(signed_in.locator("#connection")).to_have_text("Live")
    live.train(0, 4000)
    expect(signed_in.locator("#counts")).to_have_text("16 running")
    assert all("502" in complaint for complaint in complaints)
    complaints.clear()


def test_fetches_are_coalesced(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep()
    live.train(0, 800)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("figure canvas")).to_have_count(2)
    live.trouble.requests.clear()
    begun = time.monotonic()
    for start in range(800, 16_000, 800):
        live.train(start, start + 800)
        signed_in.wait_for_timeout(100)
    seconds = time.monotonic() - begun
    curves = live.trouble.requests.count(f"/api/v1/sweeps/{sweep.id}/curves")
    streams = live.trouble.requests.count(f"/api/v1/sweeps/{sweep.id}/events")
    assert 3 <= curves <= 2 * seconds + 1  # two fetches a second at most, for ten changes a second
    assert streams == 0
