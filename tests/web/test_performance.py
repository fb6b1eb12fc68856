"""How fast a large sweep's page is: 896 runs, 56 curves, 250 points each. Prints the figures."""

import json

import pytest
from playwright.sync_api import Page, expect

import physics
from tests.web.live_service import LiveService

pytestmark = pytest.mark.browser

LEARNERS = (
    ("ddpg", 0.0, 0.0),
    *(("hybrid-ddpg", w1, w2) for w1 in (0.1, 0.01) for w2 in (0.1, 0.01, 0.0)),
    ("hybrid-ddpg", 0.0, 0.1),
)
TIMESTEPS = 200_000
REDRAWS = 5


def test_896_runs(signed_in: Page, live: LiveService) -> None:
    environments = physics.names()[:7]
    sweep = live.add_sweep("large", LEARNERS, environments, seeds=16, timesteps=TIMESTEPS)
    live.train(0, TIMESTEPS)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    panels = signed_in.locator("figure canvas")
    expect(panels).to_have_count(len(environments))

    first_paint = milliseconds_to_first_panel(signed_in)
    received = signed_in.evaluate(
        "performance.getEntriesByType('resource').reduce((sum, each) => sum + each.transferSize, 0)"
    )
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


def milliseconds_to_first_panel(page: Page) -> float:
    """From navigation to the moment all panels are drawn, median of three visits."""
    times = []
    for _ in range(3):
        page.reload()
        times.append(
            page.evaluate(
                """() => new Promise((resolve) => {
                  const look = () => document.querySelectorAll("figure canvas").length >= 6
                    ? requestAnimationFrame(() => resolve(performance.now()))
                    : requestAnimationFrame(look);
                  look();
                })"""
            )
        )
    return float(sorted(times)[1])


def milliseconds_a_redraw(page: Page) -> float:
    """From a change of the view to the painted frame, median."""
    times = page.evaluate(
        """async (count) => {
          const box = document.querySelector("[name=logx]");
          const times = [];
          for (let i = 0; i < count; i++) {
            const started = performance.now();
            box.click();
            await new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
            times.push(performance.now() - started);
          }
          return times;
        }""",
        REDRAWS,
    )
    return float(sorted(times)[REDRAWS // 2])
