"""What the page says and does when the service goes away, and when it comes back."""

import time

import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import TOKEN, LiveService

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
    expect(banner).to_contain_text("Connected again. The page shows all changes since")
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
    path = "/api/v1/events"
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
    streams = sum(path.endswith("/events") for path in live.trouble.requests)
    assert 3 <= curves <= 2 * seconds + 1  # two fetches a second at most, for ten changes a second
    assert streams == 0


def test_any_number_of_tabs_stay_live(signed_in: Page, live: LiveService) -> None:
    """A browser opens six connections to a host: tabs with a stream each would use them up."""
    sweep = live.add_sweep()
    live.train(0, 4000)
    tabs = [signed_in, *(signed_in.context.new_page() for _ in range(8))]
    for tab in tabs:
        tab.goto(f"{live.url}/sweeps/{sweep.id}?table=Pendulum")
        expect(tab.locator("#connection")).to_have_text("Live")
    live.train(4000, 8000)
    for tab in tabs:
        rows = tab.get_by_role("figure", name="Pendulum").locator("tbody tr")
        expect(rows).to_have_count(10)
    assert live.trouble.requests.count("/api/v1/events") <= 2  # of the list's page, and of these


def test_a_tab_that_is_closed_leaves_the_others_their_stream(
    signed_in: Page, live: LiveService
) -> None:
    sweep = live.add_sweep()
    first = signed_in.context.new_page()
    for tab in (first, signed_in):
        tab.goto(f"{live.url}/sweeps/{sweep.id}")
        expect(tab.locator("#connection")).to_have_text("Live")
    first.close()
    live.train(0, 4000)
    expect(signed_in.locator("#counts")).to_have_text("16 running")


def test_a_browser_without_shared_workers_has_a_stream_all_the_same(
    signed_in: Page, live: LiveService
) -> None:
    signed_in.add_init_script("delete globalThis.SharedWorker")
    sweep = live.add_sweep()
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("#connection")).to_have_text("Live")
    live.train(0, 4000)
    expect(signed_in.locator("#counts")).to_have_text("16 running")


def test_a_changed_token_is_told_with_a_way_to_sign_in(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    sweep = live.add_sweep()
    live.train(0, 4000)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}?band=iqr")
    expect(signed_in.locator("#connection")).to_have_text("Live")
    signed_in.context.clear_cookies()
    expect(signed_in.locator("#connection")).to_have_text("Signed out")
    signed_in.locator("#banner").get_by_role("link", name="Sign in").click()
    expect(signed_in.get_by_role("heading", level=1)).to_have_text("Not signed in")
    signed_in.get_by_label("Token").fill("not the token")
    signed_in.get_by_role("button", name="Sign in").click()
    expect(signed_in.locator("main")).to_contain_text("This token is not valid, or not any more")
    signed_in.get_by_label("Token").fill(TOKEN)
    signed_in.get_by_role("button", name="Sign in").click()
    expect(signed_in.get_by_role("heading", level=1)).to_have_text("first look")
    assert signed_in.url == f"{live.url}/sweeps/{sweep.id}?band=iqr"
    assert all("401" in complaint for complaint in complaints)
    complaints.clear()


def test_an_address_that_leads_nowhere_is_a_page(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    signed_in.goto(f"{live.url}/nopage")
    expect(signed_in.get_by_role("heading", level=1)).to_have_text("Not Found")
    signed_in.get_by_role("link", name="To the list of sweeps").click()
    expect(signed_in.get_by_role("heading", level=1)).to_have_text("Sweeps")
    assert all("404" in complaint for complaint in complaints)
    complaints.clear()


@pytest.mark.parametrize("asked", ["?metric=nope", "/runs?after=nope"])
def test_what_cannot_be_had_is_told_and_not_asked_for_again(
    signed_in: Page, live: LiveService, complaints: list[str], asked: str
) -> None:
    sweep = live.add_sweep()
    live.train(0, 4000)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}{asked}")
    expect(signed_in.locator("#loading")).to_contain_text("or reset the view")
    expect(signed_in.locator("#loading")).to_contain_text(
        "metric" if "metric" in asked else "after"
    )
    expect(signed_in.locator("#banner")).to_be_hidden()
    signed_in.get_by_role("button", name="Reset view").click()
    expect(signed_in.locator("#loading")).to_be_hidden()
    assert all("422" in complaint for complaint in complaints)
    complaints.clear()


def test_the_page_of_the_api_has_the_theme_and_a_way_back(
    signed_in: Page, live: LiveService
) -> None:
    signed_in.get_by_label("Theme").select_option("dark")
    signed_in.get_by_role("link", name="API").first.click()
    expect(signed_in.get_by_role("heading", name="d3pg").first).to_be_visible()
    ground = signed_in.evaluate("getComputedStyle(document.body).backgroundColor")
    assert ground == "rgb(19, 21, 23)"
    signed_in.get_by_role("link", name="Back to the dashboard").click()
    expect(signed_in.get_by_role("heading", level=1)).to_have_text("Sweeps")
