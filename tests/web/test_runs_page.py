"""The runs of a sweep: filtered, sorted, paged, chosen and stopped."""

import re

import pytest
from playwright.sync_api import Locator, Page, expect

from service.model.sweep import Sweep
from tests.web.live_service import LiveService
from tests.web.test_sweep_page import state

pytestmark = pytest.mark.browser


@pytest.fixture
def sweep(live: LiveService) -> Sweep:
    sweep = live.add_sweep()
    live.train(0, 9600)
    return sweep


@pytest.fixture
def rows(signed_in: Page, live: LiveService, sweep: Sweep) -> Locator:
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}/runs")
    found = signed_in.locator(".runs tbody tr")
    expect(found).to_have_count(16)
    return found


def test_runs_are_filtered_and_sorted_by_the_address(
    rows: Locator, live: LiveService, sweep: Sweep
) -> None:
    live.diverge(seed=2)
    page = rows.page
    page.locator("[name=status]").select_option("diverged")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("critic_loss")
    assert state(page) == {"status": ["diverged"]}
    page.get_by_role("button", name="Reset view").click()
    page.get_by_label("Environment").select_option("Pendulum")
    page.get_by_label("Algorithm").select_option("hybrid-ddpg")
    page.get_by_label("Sorted by").select_option("return_mean")
    page.get_by_label("largest first").check()
    query = "environment=Pendulum&algorithm=hybrid-ddpg&sort=return_mean&descending=true"
    answer = page.request.get(f"{live.url}/api/v1/sweeps/{sweep.id}/runs?{query}").json()
    ordinals = [run["id"].rpartition("-")[2] for run in answer["items"]]
    expect(rows.get_by_role("rowheader")).to_have_text(ordinals)
    page.reload()
    expect(rows).to_have_count(4)
    expect(page.get_by_label("Sorted by")).to_have_value("return_mean")


def test_a_run_is_cancelled_alone(rows: Locator, live: LiveService) -> None:
    rows.page.get_by_role("button", name="Cancel run 0", exact=True).click()
    rows.page.get_by_role("button", name="Cancel the run").click()
    expect(rows.first).to_contain_text("cancelling")
    assert len(live.store.cancelling_runs()) == 1


def test_selected_runs_are_compared(rows: Locator, sweep: Sweep) -> None:
    page = rows.page
    selected = page.get_by_role("group", name="Selected runs")
    expect(selected.get_by_role("button", name="Compare")).to_be_disabled()
    page.get_by_role("checkbox", name="Select run 3").check()
    page.get_by_role("checkbox", name="Select run 12").check()
    expect(selected).to_contain_text("2 selected")
    selected.get_by_role("button", name="Compare").click()
    page.wait_for_url(re.compile(f"/compare\\?run={sweep.id}-3&run={sweep.id}-12$"))


def test_selected_runs_are_moved_together(rows: Locator, live: LiveService, sweep: Sweep) -> None:
    page = rows.page
    waiting = live.add_sweep("waiting", environments=("Pendulum",))
    page.goto(f"{live.url}/sweeps/{waiting.id}/runs")
    expect(rows).to_have_count(8)
    page.get_by_role("checkbox", name="Select all on this page").check()
    page.get_by_role("checkbox", name="Select run 3").uncheck()
    selected = page.get_by_role("group", name="Selected runs")
    selected.get_by_role("button", name="Pause").click()
    expect(selected.get_by_role("status")).to_have_text("7 paused.")
    expect(rows.filter(has_text="paused")).to_have_count(7)
    selected.get_by_role("button", name="Cancel").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("Cancel 7 runs?")
    dialog.get_by_role("button", name="Cancel the runs").click()
    expect(rows.filter(has_text="cancelled")).to_have_count(7)
    expect(rows.filter(has_text="queued")).to_have_count(1)
    selected.get_by_role("button", name="Clear").click()
    expect(selected).to_contain_text("None selected")


def test_rows_progress_by_themselves(rows: Locator, live: LiveService) -> None:
    expect(rows.first).to_contain_text("9,600 / 20,000")
    before = rows.first.locator("polyline").get_attribute("points")
    live.train(9600, 20_000)
    expect(rows.first).to_contain_text("succeeded")
    assert rows.first.locator("polyline").get_attribute("points") != before


def test_each_row_says_whether_its_kernels_compile(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep(environments=("Pendulum",))
    live.train(0, 0)
    compiling = signed_in.locator(".runs tbody tr", has_text="compiling or loading kernels")
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}/runs")
    expect(compiling).to_have_count(8)
    live.train(0, 1600)
    expect(compiling).to_have_count(0)
    expect(signed_in.locator(".runs tbody tr", has_text="running")).to_have_count(8)


@pytest.mark.slow
def test_ten_thousand_runs(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep("large", environments=("Pendulum",), seeds=5000, timesteps=4000)
    live.train(0, 4000)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}/runs?sort=return_mean&descending=1")
    rows = signed_in.locator(".runs tbody tr")
    expect(rows).to_have_count(100)
    expect(signed_in.locator("#range")).to_have_text("1 to 100 of 10,000")
    shown = signed_in.evaluate("performance.now()")
    first = rows.first.inner_text()
    signed_in.evaluate("performance.mark('turn')")
    signed_in.get_by_role("button", name="Next").click()
    expect(signed_in.locator("#range")).to_have_text("101 to 200 of 10,000")
    expect(rows.first).not_to_have_text(first)
    turned = signed_in.evaluate("performance.measure('turn', 'turn').duration")
    print({"ten_thousand_runs_shown_ms": round(shown), "page_turned_ms": round(turned)})  # noqa: T201
    assert turned < 1000


def test_heads_sort_by_the_final_score_and_settings_have_columns(
    signed_in: Page, live: LiveService
) -> None:
    learners = (("ddpg", 0.0, 0.0), ("hybrid-ddpg", 0.1, 0.0), ("hybrid-ddpg", 1.0, 0.0))
    sweep = live.add_sweep(learners=learners, seeds=2)
    live.train(0, 20_000)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}/runs")
    rows = signed_in.locator(".runs tbody tr")
    expect(rows).to_have_count(12)
    expect(signed_in.locator(".runs thead .setting")).to_have_text(["w1"])
    signed_in.get_by_role("button", name="Score", exact=True).click()
    assert state(signed_in) == {"sort": ["score"], "descending": ["1"]}
    head = signed_in.get_by_role("columnheader", name="Score")
    expect(head).to_have_attribute("aria-sort", "descending")

    def column(place: int) -> list[float]:
        texts = signed_in.locator(f".runs tbody tr td:nth-child({place})").all_inner_texts()
        return [float(text.replace("−", "-")) for text in texts]

    expect(rows.first).to_contain_text("hybrid-ddpg")
    assert column(9) == sorted(column(9), reverse=True)  # over both tasks, on one scale
    signed_in.get_by_role("button", name="Score", exact=True).click()
    expect(head).to_have_attribute("aria-sort", "ascending")
    expect(rows.first.locator("td").nth(3)).to_have_text("ddpg")
    assert column(9) == sorted(column(9))
    signed_in.get_by_role("button", name="w1", exact=True).click()
    expect(rows.last.locator("td").nth(4)).to_have_text("1")
    assert column(6) == sorted(column(6))
