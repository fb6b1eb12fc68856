"""Sweeps side by side: whose curve is whose."""

import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import LiveService

pytestmark = pytest.mark.browser


def test_equal_names_of_two_sweeps_are_told_apart(signed_in: Page, live: LiveService) -> None:
    first, second = live.add_sweep("twice"), live.add_sweep("twice")
    live.train(0, 4000)
    signed_in.goto(f"{live.url}/compare?sweep={first.id}&sweep={second.id}")
    labels = signed_in.locator("#legend li label")
    expect(labels).to_have_text(
        [
            f"{label} · twice ({sweep.id}) 8 runs"
            for sweep in (first, second)
            for label in ("ddpg", "hybrid-ddpg")
        ]
    )
    looks = labels.locator("line").evaluate_all(
        "all => all.map((line) => ['stroke', 'stroke-dasharray'].map((a) => line.getAttribute(a)))"
    )
    assert len({stroke for stroke, _ in looks}) == 4  # shades of each learner's colour
    assert [dash is None for _, dash in looks] == [True, True, False, False]
