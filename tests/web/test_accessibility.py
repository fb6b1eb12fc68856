"""Keyboard, contrast, names and roles, on every page in both themes; narrow screens too."""

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.web.live_service import LiveService

pytestmark = pytest.mark.browser


def violations(page: Page) -> list[str]:
    """What axe finds, by rule, with the first element of each."""
    found = Axe().run(page).response["violations"]
    return [f"{each['id']} ({each['impact']}): {each['nodes'][0]['html'][:120]}" for each in found]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(signed_in: Page, live: LiveService, scheme: str) -> None:
    signed_in.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
    expect(signed_in.get_by_role("heading", name="No sweeps yet")).to_be_visible()
    assert violations(signed_in) == []
    sweep = live.add_sweep()
    live.train(0, 9600)
    live.diverge(seed=1)
    expect(signed_in.get_by_role("row", name="first look")).to_contain_text("1 diverged")
    assert violations(signed_in) == []
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}?table=Pendulum&hide=ddpg&scale=raw")
    expect(signed_in.locator("#problems")).to_be_visible()
    assert violations(signed_in) == []
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}/runs")
    expect(signed_in.locator(".runs tbody tr")).to_have_count(16)
    assert violations(signed_in) == []
    signed_in.get_by_role("button", name="Cancel sweep").click()
    assert violations(signed_in) == []
    signed_in.goto(f"{live.url}/compare?sweep={sweep.id}&run={sweep.id}-3")
    expect(signed_in.locator("#legend li")).to_have_count(3)
    assert violations(signed_in) == []
    signed_in.goto(f'{live.url}/?new={{"algorithms":[{{"name":"hybrid-ddpg"}}]}}')
    expect(signed_in.locator("[name=algorithm][value=hybrid-ddpg]")).to_be_checked()
    assert violations(signed_in) == []
    signed_in.goto(f"{live.url}/catalogue")
    expect(signed_in.locator("#environments")).to_contain_text("Acrobot")
    assert violations(signed_in) == []


def test_text_keeps_its_contrast_while_curves_are_asked_for(
    signed_in: Page, live: LiveService
) -> None:
    sweep = live.add_sweep()
    live.train(0, 9600)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("figure canvas")).to_have_count(2)
    signed_in.route("**/curves?*", lambda route: None)  # It is never answered.
    signed_in.get_by_label("Band").select_option("ci95")
    expect(signed_in.locator("#curves")).to_have_attribute("aria-busy", "true")
    assert violations(signed_in) == []


def test_text_of_curves_that_are_left_out_keeps_its_contrast(
    signed_in: Page, live: LiveService
) -> None:
    sweep = live.add_sweep()
    live.train(0, 9600)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}?top=1")
    expect(signed_in.locator("#legend .left-out")).to_have_count(1)
    assert violations(signed_in) == []


@pytest.mark.parametrize("width", [1280, 400])
def test_nothing_sticks_out(signed_in: Page, live: LiveService, width: int) -> None:
    sweep = live.add_sweep(
        "a name that is rather longer than anybody would need to call a sweep" * 2
    )
    live.train(0, 9600)
    live.fail("ValueError: " + "x" * 300)
    signed_in.set_viewport_size({"width": width, "height": 900})
    for path in ("/", f"/sweeps/{sweep.id}?table=Pendulum", f"/sweeps/{sweep.id}/runs"):
        signed_in.goto(live.url + path)
        expect(signed_in.locator("#loading")).to_be_hidden()
        assert signed_in.evaluate("document.documentElement.scrollWidth") <= width


def test_everything_is_reached_by_tab(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep()
    live.train(0, 9600)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("figure canvas")).to_have_count(2)
    reached = []
    while True:
        signed_in.keyboard.press("Tab")
        if signed_in.evaluate("document.activeElement === document.body"):
            break
        reached.append(signed_in.evaluate("document.activeElement.outerHTML.slice(0, 200)"))
        outline = signed_in.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert outline != "none", reached[-1]
    text = "\n".join(reached)
    for sought in (
        "#content",
        'id="theme"',
        "download-png",
        'id="cancel"',
        f"/sweeps/{sweep.id}/runs",
        "copy-link",
        'name="metric"',
        'name="scale"',
        'name="x"',
        'name="band"',
        'name="logx"',
        'name="smoothing"',
        'name="seeds"',
        'type="checkbox"',
        "Show only",
        'role="slider"',
        "<summary",
        "table-latex",
        'class="sorter"',
    ):
        assert sought in text, sought
