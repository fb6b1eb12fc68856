"""Sweeps side by side: whose curve is whose."""

from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import LiveService
from tests.web.test_accessibility import violations

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


def test_compared_sweeps_have_metrics_scores_and_downloads(
    signed_in: Page, live: LiveService
) -> None:
    first = live.add_sweep("first", (("ddpg", 0.0, 0.0),), environments=("Pendulum",))
    second = live.add_sweep(
        "second", (("hybrid-ddpg", 0.1, 0.1),), environments=("Pendulum", "MassPoint")
    )
    live.train(0, 20_000)
    signed_in.goto(f"{live.url}/compare?sweep={first.id}&sweep={second.id}")
    expect(signed_in.get_by_label("Metric").locator("option")).to_have_text(
        ["return_mean", "return_history", "critic_loss"]
    )
    rows = signed_in.locator("#score-table tbody tr")
    expect(rows.get_by_role("rowheader")).to_have_text(["ddpg · first", "hybrid-ddpg · second"])
    expect(rows.first.locator("td").last).to_have_text("")  # it does not run in MassPoint
    expect(rows.locator("strong")).to_have_count(2)  # one in a task, of both sweeps
    expect(rows.last.locator("strong")).to_have_count(2)
    with signed_in.expect_download() as downloading:
        signed_in.get_by_role("button", name="CSV").click()
    lines = Path(downloading.value.path()).read_text(encoding="utf-8").splitlines()
    assert len(lines) == 1 + 3 * 25
    assert violations(signed_in) == []
