"""The list of sweeps, as a person sees it."""

import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import LiveService
from tests.web.test_accessibility import violations

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


def test_sweeps_are_found_by_words_tags_learners_and_tasks(
    signed_in: Page, live: LiveService
) -> None:
    first = live.add_sweep("morning coffee", environments=("MassPoint",))
    live.add_sweep("evening tea", learners=(("sac", 0.0, 0.0),), environments=("Pendulum",))
    live.store.edit_sweep(first.id, {"tags": ("paper",), "notes": "with *milk*"})
    rows = signed_in.locator("#sweeps tbody tr")
    expect(rows).to_have_count(2)
    expect(rows.last).to_contain_text("ddpg, hybrid-ddpg in MassPoint")
    expect(rows.last.locator(".tag")).to_have_text("paper")
    for label, text in (
        ("Find sweeps", "milk"),
        ("Tag", "paper"),
        ("Algorithm", "hybrid-ddpg"),
        ("Task", "MassPoint"),
    ):
        signed_in.get_by_label(label, exact=True).fill(text)
        expect(rows).to_have_count(1)
        expect(rows).to_contain_text("morning coffee")
        signed_in.get_by_role("button", name="Reset view").click()
        expect(rows).to_have_count(2)
    signed_in.get_by_label("Find sweeps").fill("nothing like it")
    expect(signed_in.get_by_text("No sweep matches.")).to_be_visible()
    expect(signed_in.get_by_role("heading", name="No sweeps yet")).to_be_hidden()


def test_the_best_curve_of_a_sweep_is_shown(signed_in: Page, live: LiveService) -> None:
    live.add_sweep("finished", environments=("Pendulum",))
    live.train(0, 20_000)
    best = signed_in.locator(".best-cell")
    expect(best).to_contain_text("hybrid-ddpg in Pendulum")
    expect(best.locator("polyline")).to_have_count(1)


def test_selected_sweeps_are_archived_and_compared(signed_in: Page, live: LiveService) -> None:
    sweeps = [live.add_sweep(name) for name in ("one", "two", "three")]
    rows = signed_in.locator("#sweeps tbody tr")
    for name in ("one", "two"):
        signed_in.get_by_label(f"Select {name}", exact=True).check()
    expect(signed_in.locator("#picked-count")).to_have_text("2 sweeps selected")
    signed_in.get_by_role("button", name="Archive", exact=True).click()
    expect(rows).to_have_count(1)
    signed_in.get_by_label("Archived sweeps").select_option("true")
    expect(rows).to_have_count(2)
    expect(rows.first.locator(".tag")).to_have_text("archived")
    for name in ("one", "two"):
        signed_in.get_by_label(f"Select {name}", exact=True).check()
    signed_in.get_by_role("button", name="Compare", exact=True).click()
    signed_in.wait_for_url(f"{live.url}/compare?sweep={sweeps[0].id}&sweep={sweeps[1].id}")


def test_a_sweep_is_named_and_noted(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    sweep = live.add_sweep("morning coffee")
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    signed_in.get_by_role("button", name="Name and notes").click()
    form = signed_in.get_by_role("form", name="Name and notes")
    expect(form.get_by_label("Name", exact=True)).to_be_focused()
    form.get_by_label("Name", exact=True).fill("evening tea")
    form.get_by_label("Tags").fill("paper, pendulum")
    form.get_by_label("Notes").fill("with *milk* <b>and</b>\nsugar")
    form.get_by_label("Priority").fill("5000")
    form.get_by_role("button", name="Save").click()
    expect(form.locator("[data-fault=priority] .fault")).to_contain_text("1000")
    assert violations(signed_in) == []
    form.get_by_label("Priority").fill("5")
    form.get_by_role("button", name="Save").click()
    expect(form).to_be_hidden()
    expect(signed_in.get_by_role("heading", level=1)).to_have_text("evening tea")
    expect(signed_in.locator("#notes")).to_have_text("with *milk* <b>and</b>\nsugar")
    expect(signed_in.locator("#tags .tag")).to_have_text(["paper", "pendulum"])
    assert all("422" in complaint for complaint in complaints)
    complaints.clear()


def test_sweeps_are_deleted_when_that_is_meant(signed_in: Page, live: LiveService) -> None:
    for name in ("one", "two"):
        live.add_sweep(name, seeds=1)
    live.train(0, 20_000)
    running = live.add_sweep("running", seeds=1)
    live.train(0, 800)
    rows = signed_in.locator("#sweeps tbody tr")
    expect(rows).to_have_count(3)
    for name in ("one", "two", "running"):
        signed_in.get_by_label(f"Select {name}", exact=True).check()
    delete = signed_in.get_by_role("button", name="Delete", exact=True)
    delete.click()
    expect(signed_in.get_by_role("dialog")).to_contain_text("Delete 3 sweeps?")
    signed_in.keyboard.press("Escape")
    expect(rows).to_have_count(3)
    delete.click()
    signed_in.get_by_role("button", name="Delete the sweeps").click()
    expect(rows).to_have_count(1)
    expect(signed_in.locator("#picked-state")).to_contain_text("2 deleted. 1 refused:")
    expect(signed_in.locator("#picked-count")).to_have_text("1 sweep selected")
    signed_in.goto(f"{live.url}/sweeps/{running.id}")
    expect(signed_in.get_by_role("button", name="Delete sweep")).to_be_hidden()
    live.train(800, 20_000)
    signed_in.get_by_role("button", name="Delete sweep").click()
    signed_in.get_by_role("button", name="Delete the sweep").click()
    signed_in.wait_for_url(f"{live.url}/")
    expect(signed_in.get_by_role("heading", name="No sweeps yet")).to_be_visible()


def test_a_view_is_kept_by_name_in_the_browser(signed_in: Page, live: LiveService) -> None:
    live.add_sweep("the first")
    live.add_sweep("the second")
    signed_in.goto(live.url)
    rows = signed_in.locator("#sweeps tbody tr")
    expect(rows).to_have_count(2)
    expect(signed_in.locator("#saved-views")).to_be_hidden()
    signed_in.get_by_label("Find sweeps").fill("second")
    expect(rows).to_have_count(1)
    signed_in.get_by_label("Name of this view").fill("mine, <b>now</b>")
    signed_in.get_by_role("button", name="Save view").click()
    expect(signed_in.get_by_role("status").filter(has_text="Saved")).to_be_visible()
    assert violations(signed_in) == []
    signed_in.goto(live.url)
    expect(rows).to_have_count(2)
    views = signed_in.get_by_role("combobox", name="Saved views")
    views.select_option("mine, <b>now</b>")
    expect(rows).to_have_count(1)
    assert "q=second" in signed_in.url
    signed_in.get_by_role("button", name="Reset view").click()
    expect(rows).to_have_count(2)
    expect(views).to_have_value("")
    views.select_option("mine, <b>now</b>")
    signed_in.get_by_role("button", name="Remove this view").click()
    expect(views).to_be_hidden()
    expect(rows).to_have_count(1)


def test_storage_that_holds_something_else_is_no_view(signed_in: Page, live: LiveService) -> None:
    live.add_sweep("the first")
    signed_in.evaluate("localStorage.setItem('d3pg.views', '[1, 2')")
    signed_in.goto(live.url)
    expect(signed_in.locator("#sweeps tbody tr")).to_have_count(1)
    expect(signed_in.locator("#saved-views")).to_be_hidden()
