"""The list of sweeps, as a person sees it."""

import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import LiveService

pytestmark = pytest.mark.browser


def test_an_empty_service_says_how_to_submit(signed_in: Page, live: LiveService) -> None:
    expect(signed_in.get_by_role("heading", name="No sweeps yet")).to_be_visible()
    expect(signed_in.get_by_text("d3pg submit first.yaml")).to_be_visible()
    expect(signed_in.get_by_text(f"curl {live.url}/api/v1/sweeps")).to_be_visible()


def test_a_new_sweep_appears_and_progresses_by_itself(signed_in: Page, live: LiveService) -> None:
    expect(signed_in.get_by_role("heading", name="No sweeps yet")).to_be_visible()
    live.add_sweep("morning coffee")
    row = signed_in.get_by_role("row", name="morning coffee")
    expect(row).to_contain_text("2 learners × 2 environments × 4 seeds, 20,000 timesteps")
    expect(row).to_contain_text("16 queued")
    expect(row).to_contain_text("0 %")
    live.train(0, 10_000)
    expect(row).to_contain_text("16 running")
    expect(row).to_contain_text("50 %")
    expect(row.get_by_role("progressbar")).to_have_attribute(
        "aria-label", "Progress of morning coffee"
    )
    live.train(10_000, 20_000)
    expect(row).to_contain_text("16 succeeded")
    expect(row).to_contain_text("finished")
    expect(row.get_by_role("button")).to_have_count(0)


def test_a_name_is_text_and_not_html(signed_in: Page, live: LiveService) -> None:
    name = "<img src=x onerror=document.title='broken'> & <b>bold</b>"
    sweep = live.add_sweep(name)
    signed_in.get_by_role("link", name=name).click()
    signed_in.wait_for_url(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.get_by_role("heading", level=1)).to_have_text(name)
    assert signed_in.locator("main img").count() == 0


def test_cancelling_asks_first(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep("a mistake")
    cancel = signed_in.get_by_role("button", name="Cancel a mistake")
    dialog = signed_in.get_by_role("dialog")
    cancel.click()
    expect(dialog).to_contain_text("Cancel “a mistake”?")
    expect(dialog).to_contain_text("16 queued runs will stop for good.")
    expect(dialog.get_by_role("button", name="Let it run")).to_be_focused()
    signed_in.keyboard.press("Enter")
    expect(dialog).to_be_hidden()
    assert live.store.find_sweep(sweep.id).runs.queued == 16  # type: ignore[union-attr]

    cancel.click()
    dialog.get_by_role("button", name="Cancel the sweep").click()
    row = signed_in.get_by_role("row", name="a mistake")
    expect(row).to_contain_text("16 cancelled")
    expect(row).to_contain_text("cancelled")
    assert live.store.find_sweep(sweep.id).runs.cancelled == 16  # type: ignore[union-attr]


def test_a_refused_cancel_says_why(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    sweep = live.add_sweep("stubborn")
    live.trouble.failing[f"/api/v1/sweeps/{sweep.id}/cancel"] = 409
    signed_in.get_by_role("button", name="Cancel stubborn").click()
    signed_in.get_by_role("button", name="Cancel the sweep").click()
    expect(signed_in.get_by_text("The database is on holiday.")).to_be_visible()
    assert len(complaints) == 1  # the browser logs every refused request
    complaints.clear()


def test_older_sweeps_come_on_demand_and_stay_live(signed_in: Page, live: LiveService) -> None:
    live.add_sweep("the oldest", seeds=1)
    for i in range(60):
        live.add_sweep(f"sweep {i}", seeds=1)
    rows = signed_in.locator("#sweeps tbody tr")
    expect(rows).to_have_count(50)
    expect(rows.first).to_contain_text("sweep 59")
    signed_in.get_by_role("button", name="Show older sweeps").click()
    expect(rows).to_have_count(61)
    expect(rows.last).to_contain_text("the oldest")
    expect(signed_in.get_by_role("button", name="Show older sweeps")).to_be_hidden()
    live.train(0, 800)
    expect(rows.last).to_contain_text("4 running")
