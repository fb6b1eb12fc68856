"""Signing in and out, sharing what is on the page, and what others see of it."""

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect

from service.client import Client
from service.model.caller import Scope
from tests.web.live_service import TOKEN, LiveService

pytestmark = pytest.mark.browser


def violations(page: Page) -> list[str]:
    found = Axe().run(page).response["violations"]
    return [f"{each['id']}: {each['nodes'][0]['html'][:120]}" for each in found]


def signed_in_as(live: LiveService, page: Page, name: str, scope: Scope) -> None:
    """Sign in by a token that is pasted, as a colleague does."""
    token = live.register.add_user(name, scope)
    page.goto(f"{live.url}/signin")
    page.get_by_label("Token").fill(token)
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("button", name="Sign out")).to_be_visible()
    assert token not in page.url


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_sweep_is_shared_from_its_page(
    signed_in: Page, live: LiveService, browser: Browser, scheme: str
) -> None:
    sweep = live.add_sweep()
    live.train(0, 4000)
    signed_in.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}?table=Pendulum")
    signed_in.get_by_role("button", name="Share").click()
    signed_in.get_by_label("For how long").select_option("a day")
    signed_in.get_by_role("button", name="Make a link to read this").click()
    expect(signed_in.locator("#share-state")).to_contain_text("can read this sweep until")
    assert violations(signed_in) == []
    link = signed_in.get_by_role("textbox", name="Link", exact=True).input_value()

    stranger = browser.new_page()
    stranger.goto(link)
    expect(stranger.locator("figure canvas")).to_have_count(2)
    assert stranger.url == f"{live.url}/sweeps/{sweep.id}?table=Pendulum"
    expect(stranger.locator("#connection")).to_have_text("Live")
    live.train(4000, 8000)
    rows = stranger.get_by_role("figure", name="Pendulum").locator("tbody tr")
    expect(rows).to_have_count(10)
    expect(stranger.get_by_role("navigation", name="Pages")).to_have_text(
        "Shared with you, read only"
    )
    for name in ("Cancel sweep", "Name and notes", "Share", "Diagnose"):
        expect(stranger.get_by_role("button", name=name)).to_have_count(0)
    assert violations(stranger) == []

    signed_in.get_by_role("button", name="Revoke").click()
    expect(signed_in.locator("#share-state")).to_have_text("The link is revoked.")
    stranger.reload()
    expect(stranger.get_by_role("heading", level=1)).to_have_text("Not signed in")
    stranger.close()


def test_a_guest_goes_from_page_to_page_of_what_is_shared(
    live: LiveService, page: Page, complaints: list[str]
) -> None:
    shared, other = live.add_sweep("ours"), live.add_sweep("not theirs")
    live.train(0, 4000)
    _, token = live.register.add_share((shared.id,), f"/sweeps/{shared.id}", 1, "admin")
    page.goto(f"{live.url}/signin#share={token}")
    expect(page.locator("figure canvas")).to_have_count(2)
    complaints.clear()  # of the page that asked for a token
    page.get_by_role("link", name="Runs", exact=False).click()
    page.locator(".runs tbody th a").first.click()
    expect(page.locator("#name")).to_contain_text("seed")
    expect(page.locator("#settings dt").first).to_be_visible()
    page.goto(f"{live.url}/compare?sweep={shared.id}")
    expect(page.locator("#legend li")).to_have_count(2)
    expect(page.locator("#adding")).to_be_hidden()
    assert complaints == []
    page.goto(f"{live.url}/sweeps/{other.id}")
    expect(page.locator("main")).to_contain_text("not shared with you")
    assert "not theirs" not in page.content()


def test_a_comparison_is_shared_with_its_view(signed_in: Page, live: LiveService) -> None:
    sweeps = [live.add_sweep(name) for name in ("one", "two")]
    live.train(0, 4000)
    view = f"/compare?sweep={sweeps[0].id}&run={sweeps[1].id}-3"
    signed_in.goto(f"{live.url}{view}")
    expect(signed_in.locator("#legend li")).to_have_count(3)
    signed_in.get_by_role("button", name="Share").click()
    signed_in.get_by_role("button", name="Make a link to read this").click()
    expect(signed_in.locator("#share-state")).to_contain_text("these 2 sweeps, whole")
    [share] = live.register.shares()
    assert set(share.sweeps) == {each.id for each in sweeps}
    assert share.page.startswith("/compare?")


def test_a_reader_is_offered_nothing_that_changes(live: LiveService, page: Page) -> None:
    sweep = live.add_sweep()
    live.train(0, 4000)
    signed_in_as(live, page, "bob", Scope.READ)
    expect(page.get_by_role("row", name="first look")).to_contain_text("by admin")
    for name in ("New sweep", "Cancel first look"):
        expect(page.get_by_role("button", name=name)).to_have_count(0)
    page.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(page.locator("#summary")).to_contain_text("submitted by admin")
    expect(page.locator("figure canvas")).to_have_count(2)
    for name in ("Cancel sweep", "Pause", "Share", "Name and notes"):
        expect(page.get_by_role("button", name=name)).to_have_count(0)
    assert violations(page) == []


def test_who_submits_changes_what_is_their_own(live: LiveService, page: Page) -> None:
    of_admin = live.add_sweep("of the administrator")
    signed_in_as(live, page, "ann", Scope.SUBMIT)
    token = live.register.add_user("ann-s-program", Scope.SUBMIT)
    with Client(live.url, token) as program:
        request = {"algorithms": [{"name": "ddpg"}], "environments": ["Pendulum"], "seeds": 1}
        of_program = program.submit(request).id
    live.store.write(
        lambda connection: connection.exec_driver_sql(
            "UPDATE sweeps SET owner = 'ann' WHERE id = ?", (of_program,)
        )
    )
    page.goto(f"{live.url}/sweeps/{of_admin.id}")
    expect(page.locator("#summary")).to_contain_text("by admin")
    expect(page.get_by_role("link", name="Submit another like it")).to_be_visible()
    expect(page.get_by_role("button", name="Cancel sweep")).to_have_count(0)
    page.goto(f"{live.url}/sweeps/{of_program}")
    expect(page.get_by_role("button", name="Cancel sweep")).to_be_visible()
    expect(page.locator("#summary")).not_to_contain_text("by ")


def test_signing_out_ends_what_other_tabs_show(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    other = signed_in.context.new_page()
    other.goto(live.url)
    expect(other.locator("#connection")).to_have_text("Live")
    signed_in.get_by_role("button", name="Sign out").click()
    expect(signed_in.get_by_role("heading", level=1)).to_have_text("Not signed in")
    assert violations(signed_in) == []
    live.add_sweep("a secret since")
    expect(other.locator("#connection")).to_have_text("Signed out")
    assert "a secret since" not in other.content()
    other.close()
    assert all("401" in complaint for complaint in complaints)
    complaints.clear()


def test_one_user_on_one_machine_notices_nothing(signed_in: Page, live: LiveService) -> None:
    live.add_sweep()
    row = signed_in.get_by_role("row", name="first look")
    expect(row).to_be_visible()
    expect(row).not_to_contain_text("by ")
    assert "admin" not in signed_in.inner_text("body")
    assert TOKEN not in signed_in.content()
