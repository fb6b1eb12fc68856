"""Adding runs to a sweep in its page: what that is, is said before it is sent."""

import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import LiveService
from tests.web.test_accessibility import violations

pytestmark = pytest.mark.browser


def test_seeds_and_entries_are_added(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep(environments=("Pendulum",))
    live.train(0, 20_000)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    opener = signed_in.get_by_role("button", name="Add runs")
    opener.click()
    seeds = signed_in.get_by_label("New seeds, for every curve")
    send = signed_in.get_by_role("button", name="Add them")
    expect(seeds).to_be_focused()
    expect(send).to_be_disabled()
    product = signed_in.locator("#growth-product")
    seeds.fill("4-6, 9")
    expect(product).to_contain_text("2 × 1 × 4 seeds = 8 runs, 160,000 timesteps")
    assert violations(signed_in) == []
    assert live.store.get_sweep(sweep.id).runs.total == 8
    send.click()
    expect(signed_in.locator("#counts")).to_contain_text("8 queued")
    expect(opener).to_be_focused()
    opener.click()
    signed_in.get_by_role("radio", name="entries").check()
    entries = signed_in.get_by_label("New entries, in every task")
    entries.fill("ddpg:noise=0.11,0.12\nhybrid-ddpg:1,0:label=mine")
    expect(product).to_contain_text("3 × 1 × 8 seeds = 24 runs")
    send.click()
    expect(signed_in.locator("#counts")).to_contain_text("32 queued")
    labels = signed_in.locator("#legend li label")
    live.train(0, 800)
    expect(labels).to_have_count(5)
    expect(labels.last).to_contain_text("mine")


def test_what_cannot_be_added_says_why(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    sweep = live.add_sweep(environments=("Pendulum",))
    live.train(0, 20_000)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}/runs")
    signed_in.get_by_role("button", name="Add runs").click()
    form = signed_in.get_by_role("form", name="Add runs")
    signed_in.get_by_label("New seeds, for every curve").fill("3")
    expect(form).to_contain_text("3 is one of its seeds already")
    expect(signed_in.get_by_role("button", name="Add them")).to_be_disabled()
    signed_in.get_by_role("radio", name="timesteps", exact=True).check()
    signed_in.get_by_label("Timesteps of each run").fill("800")
    expect(form).to_contain_text("must be more than the 20000 of its runs")
    assert all("422" in complaint for complaint in complaints)
    complaints.clear()
    signed_in.get_by_label("Timesteps of each run").fill("40000")
    expect(signed_in.locator("#growth-product")).to_contain_text("8 runs, 160,000 timesteps")
    signed_in.get_by_role("button", name="Add them").click()
    expect(signed_in.locator("#counts")).to_contain_text("8 queued")


def test_a_cancelled_sweep_offers_no_more(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep()
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.get_by_role("button", name="Add runs")).to_be_visible()
    live.store.move_sweep(sweep.id, "cancel")
    expect(signed_in.get_by_role("button", name="Add runs")).to_be_hidden()
