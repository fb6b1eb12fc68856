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


def test_sweeps_are_compared_pair_by_pair_and_drawn_as_one(
    signed_in: Page, live: LiveService
) -> None:
    first = live.add_sweep("old", (("ddpg", 0.0, 0.0),), environments=("Pendulum",))
    second = live.add_sweep("new", (("hybrid-ddpg", 0.1, 0.1),), environments=("Pendulum",))
    live.train(0, 20_000)
    signed_in.goto(f"{live.url}/compare?sweep={first.id}&sweep={second.id}&statistics=1")
    differences = signed_in.get_by_role("region", name="Paired differences in area")
    expect(differences).to_contain_text("Pendulum: hybrid-ddpg · new − ddpg · old")
    expect(differences).to_contain_text("of 4 pairs won")
    assert violations(signed_in) == []
    signed_in.get_by_label("compared with").select_option("hybrid-ddpg · new")
    expect(differences).to_contain_text("Pendulum: ddpg · old − hybrid-ddpg · new")
    signed_in.get_by_role("button", name="Pendulum").click()
    expect(signed_in.locator("#score-table tbody th").first).to_have_text("hybrid-ddpg · new")
    together = f"{first.id}+{second.id}"
    for name, path in (("LaTeX", "table?"), ("SVG", "plot.svg?"), ("Report", "report")):
        link = signed_in.get_by_role("link", name=name, exact=True)
        assert f"/sweeps/{together}/{path}" in (link.get_attribute("href") or "")
    colours = signed_in.locator("#legend line").evaluate_all(
        "all => all.map((line) => line.getAttribute('stroke'))"
    )
    in_table = signed_in.locator("#score-table line").evaluate_all(
        "all => all.map((line) => line.getAttribute('stroke'))"
    )
    assert set(in_table) == set(colours)


def test_runs_alone_have_no_scores_and_no_file(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep()
    live.train(0, 9600)
    signed_in.goto(f"{live.url}/compare?run={sweep.id}-0&run={sweep.id}-4")
    expect(signed_in.locator("#legend li")).to_have_count(2)
    for gone in ("#scores", "#statistics", "#downloads-shown", "#figure-builder"):
        expect(signed_in.locator(gone)).to_be_hidden()
    expect(signed_in.get_by_role("button", name="CSV")).to_be_visible()
