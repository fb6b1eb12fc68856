"""How fast a large sweep's page is: 896 runs, 56 curves, 250 points each. Prints the figures.

Best of several, because the machine may be busy with other things; they must hold all the same.
"""

import json

import pytest
from playwright.sync_api import Page, expect

import physics
from tests.web.live_service import LiveService

pytestmark = [pytest.mark.browser, pytest.mark.slow]

LEARNERS = (
    ("ddpg", 0.0, 0.0),
    *(("hybrid-ddpg", w1, w2) for w1 in (0.1, 0.01) for w2 in (0.1, 0.01, 0.0)),
    ("hybrid-ddpg", 0.0, 0.1),
)
TIMESTEPS = 200_000
VISITS = 3
REDRAWS = 8


def test_896_runs(signed_in: Page, live: LiveService) -> None:
    environments = physics.names()[:7]
    sweep = live.add_sweep("large", LEARNERS, environments, seeds=16, timesteps=TIMESTEPS)
    live.train(0, TIMESTEPS)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    panels = signed_in.locator("figure canvas")
    expect(panels).to_have_count(len(environments))

    session = signed_in.context.new_cdp_session(signed_in)
    session.send("Network.enable")
    session.send("Network.setCacheDisabled", {"cacheDisabled": True})
    first_paint = milliseconds_until(signed_in, "figure canvas", len(environments))
    received = received_bytes(signed_in)
    redraw = milliseconds_a_redraw(signed_in)
    figures = {
        "runs": 128 * len(environments),
        "first_paint_ms": round(first_paint),
        "redraw_ms": round(redraw),
        "received_kb": round(received / 1000),
    }
    print(json.dumps(figures))  # noqa: T201
    assert first_paint < 1000
    assert redraw < 150
    assert received < 1_000_000


def milliseconds_a_redraw(page: Page) -> float:
    """From a change of the view to the painted frame, best of some."""
    script = """async (count) => {
      const box = document.querySelector("[name=logx]");
      const times = [];
      for (let i = 0; i < count; i++) {
        const started = performance.now();
        box.click();
        await new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
        times.push(performance.now() - started);
      }
      return times;
    }"""
    return float(min(page.evaluate(script, REDRAWS)))


TASKS = 10
ENTRIES = tuple(("hybrid-ddpg", round(0.05 * k, 2), 0.0) for k in range(1, 21))


def test_a_year_of_sweeps(signed_in: Page, live: LiveService) -> None:
    """500 sweeps in the list; in one of them 20 entries in 10 tasks with 32 seeds each."""
    for place in range(500):
        live.add_sweep(f"sweep {place}", seeds=1, environments=("Pendulum",), timesteps=1600)
    live.train(0, 1600)
    environments = physics.names()[:TASKS]
    sweep = live.add_sweep("the year's", ENTRIES, environments, seeds=32, timesteps=20_000)
    live.train(0, 20_000)

    session = signed_in.context.new_cdp_session(signed_in)
    session.send("Network.enable")
    session.send("Network.setCacheDisabled", {"cacheDisabled": True})
    signed_in.goto(live.url)
    list_paint = milliseconds_until(signed_in, "#sweeps tbody tr", 50)
    list_received = received_bytes(signed_in)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    first_paint = milliseconds_until(signed_in, "figure.panel canvas", TASKS)
    expect(signed_in.locator("#score-table tbody tr")).to_have_count(len(ENTRIES))
    figures = {
        "list_first_paint_ms": round(list_paint),
        "list_received_kb": round(list_received / 1000),
        "sweep_first_paint_ms": round(first_paint),
        "sweep_received_kb": round(received_bytes(signed_in) / 1000),
        "sweep_redraw_ms": round(milliseconds_a_redraw(signed_in)),
    }
    print(json.dumps(figures))  # noqa: T201
    assert figures["list_first_paint_ms"] < 1000
    assert figures["sweep_first_paint_ms"] < 1000
    assert figures["sweep_redraw_ms"] < 100
    assert figures["list_received_kb"] < 2000
    assert figures["sweep_received_kb"] < 2000


def milliseconds_until(page: Page, selector: str, count: int) -> float:
    """From navigation to the frame with so many elements, best of some visits."""
    times = []
    for _ in range(VISITS):
        page.reload()
        script = """([selector, count]) => new Promise((resolve) => {
          const look = () => document.querySelectorAll(selector).length >= count
            ? requestAnimationFrame(() => resolve(performance.now()))
            : requestAnimationFrame(look);
          look();
        })"""
        times.append(float(page.evaluate(script, [selector, count])))
    return min(times)


def received_bytes(page: Page) -> int:
    """What a page's resources weighed on the way."""
    return int(
        page.evaluate(
            "performance.getEntriesByType('resource')"
            ".reduce((sum, each) => sum + each.encodedBodySize, 0)"
        )
    )
