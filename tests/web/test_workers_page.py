"""Workers and the queue, as a person sees them."""

import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import LiveService
from tests.web.test_accessibility import violations

pytestmark = pytest.mark.browser


def test_who_trains_what_and_what_waits(signed_in: Page, live: LiveService) -> None:
    signed_in.get_by_role("link", name="Workers").click()
    expect(signed_in.get_by_text("No worker is up.")).to_be_visible()
    expect(signed_in.get_by_text("Nothing waits.")).to_be_visible()
    live.dispatcher.workers = {"idle one": False, "test": True}
    live.add_sweep("training", environments=("Pendulum",))
    live.train(0, 5000)
    live.add_sweep("waiting", seeds=2)
    row = signed_in.get_by_role("row", name="test").first
    expect(row).to_contain_text("of training")
    expect(row).to_contain_text("4 runs")
    expect(row).to_contain_text("25 %")
    expect(signed_in.get_by_role("row", name="idle one")).to_contain_text("idle")
    queue = signed_in.get_by_role("region", name="What waits").get_by_role("row", name="waiting")
    expect(queue).to_contain_text("a worker is about to take them")
    assert violations(signed_in) == []
