"""The policy acting: drawn, played, scrubbed, by mouse and keyboard."""

import re

import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import LiveService
from tests.web.recorded_episode import episode, offer
from tests.web.test_accessibility import violations
from tests.web.test_sweep_page import state

pytestmark = pytest.mark.browser


def opened(page: Page, live: LiveService, environment: str) -> None:
    sweep = live.add_sweep(environments=(environment,), seeds=1)
    live.train(0, 20_000)
    offer(page, f"{sweep.id}-0", episode(environment))
    page.goto(f"{live.url}/runs/{sweep.id}-0")
    expect(page.get_by_role("heading", name="The policy acting")).to_be_visible()


def pixels(page: Page, canvas: str = "#stage") -> str:
    drawn: str = page.locator(canvas).evaluate("each => each.toDataURL()")
    return drawn


def test_the_die_is_played_and_scrubbed(signed_in: Page, live: LiveService) -> None:
    opened(signed_in, live, "RollingDie")
    expect(signed_in.locator("#step-text")).to_contain_text("step 0 of ")
    first = pixels(signed_in)
    signed_in.get_by_label("Speed").select_option("4")
    signed_in.get_by_role("button", name="Play").click()
    expect(signed_in.get_by_role("button", name="Pause")).to_be_visible()
    expect(signed_in.get_by_role("button", name="Play")).to_be_visible()
    expect(signed_in.locator("#step-text")).to_contain_text("step 120 of 120")
    assert state(signed_in) == {"step": ["120"], "speed": ["4"]}
    assert pixels(signed_in) != first
    signed_in.get_by_role("button", name="Play").focus()
    signed_in.keyboard.press(",")
    expect(signed_in.get_by_role("img", name=re.compile("RollingDie at step 119 "))).to_be_visible()
    scrub = signed_in.get_by_role("slider", name="Step of the episode")
    scrub.fill("30")
    expect(signed_in.locator("#step-text")).to_contain_text(
        re.compile(r"step 30 of 120, 1\.50 s, reward")
    )
    expect(signed_in.locator("#stage-text")).to_contain_text("Red arrows are contact impulses, the")
    with signed_in.expect_request("**/rollout?seed=7"):
        signed_in.get_by_label("Start").fill("7")
        signed_in.keyboard.press("Tab")
    expect(signed_in.locator("#step-text")).to_contain_text("step 0 of ")
    assert state(signed_in) == {"start": ["7"], "speed": ["4"]}
    assert violations(signed_in) == []


def test_the_policy_is_downloaded(signed_in: Page, live: LiveService) -> None:
    opened(signed_in, live, "Pendulum")
    (run,) = re.findall(r"/runs/([\w-]+)", signed_in.url)
    link = signed_in.get_by_role("link", name="Download the policy")
    expect(link).to_be_visible()
    assert link.get_attribute("href") == f"/api/v1/runs/{run}/policy"
    assert violations(signed_in) == []


def test_the_critic_of_the_mass_point_is_shown(signed_in: Page, live: LiveService) -> None:
    opened(signed_in, live, "MassPoint")
    surface = signed_in.locator("#surface")
    expect(surface).to_contain_text("The critic’s Q over position (across) and action (up)")
    first = pixels(signed_in, "#surface canvas")
    signed_in.get_by_role("slider", name="Step of the episode").fill("5")
    expect(signed_in.locator("#step-text")).to_contain_text("step 5 of")
    assert pixels(signed_in, "#surface canvas") != first
    light = pixels(signed_in)
    signed_in.get_by_label("Theme").select_option("dark")
    assert pixels(signed_in) != light
