"""Where gradients help: asked for with a button on a sweep's and a run's page, shown as figures."""

import re

import pytest
from playwright.sync_api import Locator, Page, expect

from service.model.sweep import Sweep
from tests.service.found import find
from tests.web.live_service import LiveService
from tests.web.test_accessibility import violations
from tests.workers.policies.test_rollout import write_policy

pytestmark = pytest.mark.browser

MADE_MILLISECONDS = 120_000  # in a process that is started for it


@pytest.fixture
def sweep(live: LiveService) -> Sweep:
    """A sweep of two tasks that has ended."""
    sweep = live.add_sweep(environments=("MassPoint", "Pendulum"), seeds=2)
    live.train(0, 20_000)
    return sweep


def section(page: Page) -> Locator:
    return page.get_by_role("region", name="Where gradients help")


def pictures_are_drawn(page: Page, count: int) -> None:
    pictures = section(page).get_by_role("img")
    expect(pictures).to_have_count(count)
    for picture in pictures.all():
        expect(picture).to_have_js_property("complete", True)
        expect(picture).to_have_attribute("src", re.compile("^blob:"))
        assert picture.evaluate("image => image.decode().then(() => image.naturalWidth)") > 0


def test_a_run_is_diagnosed_on_its_page(signed_in: Page, live: LiveService, sweep: Sweep) -> None:
    write_policy(live.settings.checkpoint_place, f"{sweep.id}-0", "MassPoint")
    signed_in.goto(f"{live.url}/runs/{sweep.id}-0")
    section(signed_in).get_by_role("button", name="Diagnose").click()
    expect(section(signed_in)).to_contain_text("1 run diagnosed.", timeout=MADE_MILLISECONDS)
    section(signed_in).scroll_into_view_if_needed()
    pictures_are_drawn(signed_in, 4)
    expect(section(signed_in).get_by_role("button")).to_have_count(0)
    growth = section(signed_in).get_by_role("figure").filter(has_text="Growth")
    expect(growth).to_contain_text("If it grows with each doubling of H")
    expect(
        growth.get_by_role("link", name="Growth of gradients through time as PDF")
    ).to_be_visible()
    assert violations(signed_in) == []


@pytest.mark.parametrize("width", [1280, 390])
def test_a_sweep_shows_its_progress_and_a_task_at_a_time(
    signed_in: Page, live: LiveService, sweep: Sweep, width: int
) -> None:
    """The test plays the diagnoser: the service's own waits for none that it was not told of."""
    signed_in.set_viewport_size({"width": width, "height": 720})
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    runs = [each.run for each in live.store.list_diagnoses(sweep.id, most_of_cell=2)]
    expect(section(signed_in)).to_contain_text("what each of 8 runs has learned")
    live.store.ask_diagnoses(runs, 8)
    expect(section(signed_in)).to_contain_text("0 of 8 runs diagnosed …")
    expect(section(signed_in).get_by_role("progressbar")).to_be_visible()
    live.store.record_diagnosis(runs[0], None, "The diagnosis of <b>it</b> was ended.")
    expect(section(signed_in)).to_contain_text("1 of 8 runs diagnosed …")
    find(live.store)
    expect(section(signed_in)).to_contain_text("7 runs diagnosed.")
    expect(section(signed_in).get_by_role("button", name="Try again")).to_be_visible()
    expect(section(signed_in).get_by_role("listitem")).to_have_text(
        "The diagnosis of <b>it</b> was ended."
    )
    section(signed_in).scroll_into_view_if_needed()
    pictures_are_drawn(signed_in, 4)
    first = section(signed_in).get_by_role("img").first.get_attribute("src")
    section(signed_in).get_by_label("Task").select_option("Pendulum")
    expect(section(signed_in).get_by_role("img").first).not_to_have_attribute("src", first or "")
    pictures_are_drawn(signed_in, 4)
    assert signed_in.evaluate("document.documentElement.scrollWidth") <= width
    assert violations(signed_in) == []


def test_before_the_end_it_cannot_be_asked_for(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep(environments=("Pendulum",), seeds=1)
    live.train(0, 1600)
    for path in (f"/runs/{sweep.id}-0", f"/sweeps/{sweep.id}"):
        signed_in.goto(live.url + path)
        expect(section(signed_in)).to_contain_text("needs a run that has reached its end")
        expect(section(signed_in).get_by_role("button")).to_have_count(0)
    live.train(1600, 20_000)
    expect(section(signed_in).get_by_role("button", name="Diagnose")).to_be_visible()


def test_a_refusal_is_told(
    signed_in: Page, live: LiveService, sweep: Sweep, complaints: list[str]
) -> None:
    """Of a run that has learned nothing."""
    signed_in.goto(f"{live.url}/runs/{sweep.id}-0")
    section(signed_in).get_by_role("button", name="Diagnose").click()
    expect(signed_in.get_by_text("(succeeded) has no policy")).to_be_visible()
    expect(section(signed_in).get_by_role("button", name="Diagnose")).to_be_enabled()
    assert all("409" in complaint for complaint in complaints)
    complaints.clear()
