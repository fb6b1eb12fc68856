"""The verdict on a sweep's page: nothing without a question, then it forms, then it stands."""

import re

import pytest
from playwright.sync_api import Page, expect

from service.client import Client
from service.queue.question_rounds import look_at_all
from tests.web.live_service import TOKEN, LiveService
from tests.web.test_accessibility import violations

pytestmark = [
    pytest.mark.browser,
    pytest.mark.filterwarnings("ignore::service.client.SubmissionNotice"),
]

TASKS = ["MassPoint", "Pendulum"]
STEPS = 20_000


def asked(live: LiveService, **question: object) -> str:
    """The id of a sweep that asks whether the hybrid beats ddpg."""
    for task in TASKS:
        live.measure_random(task)
    with Client(live.url, TOKEN) as client:
        return client.submit({
            "name": "does it help?",
            "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg"}],
            "environments": TASKS,
            "seeds": 4,
            "timesteps": STEPS,
            "question": {
                "compare": ["hybrid-ddpg"], "with": "ddpg", "batch": 4, "clip": 0.5, **question
            },
        }).id  # fmt: skip


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_forms_and_stands(signed_in: Page, live: LiveService, scheme: str) -> None:
    signed_in.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
    sweep = asked(live, max_seeds=40)
    signed_in.goto(f"{live.url}/sweeps/{sweep}")
    verdict = signed_in.get_by_role("region", name="Verdict")
    expect(signed_in.locator("article")).to_contain_text("2 environments × 4 seeds or more")
    first = verdict.get_by_role("listitem").filter(has_text="Pendulum: hybrid-ddpg vs ddpg")
    expect(first).to_contain_text("not decided: its first runs have not ended")
    live.train(0, STEPS)
    expect(first).to_contain_text("4 seeds so far; about")
    expect(first).to_contain_text("power")
    expect(signed_in.locator("#curves[aria-busy]")).to_have_count(0)  # faint until then
    assert violations(signed_in) == []
    while look_at_all(live.store):
        live.train(0, STEPS)
    expect(first).to_contain_text("better by 0.")
    drawn = re.compile(re.escape(f"as it narrows. 4 pairs: {bounds(live, sweep, 0)};"))
    expect(first.get_by_role("img")).to_have_accessible_name(drawn)
    verdict.get_by_text("In a sentence for a paper").click()
    expect(verdict).to_contain_text("Better than ddpg: hybrid-ddpg in MassPoint")
    expect(verdict).to_contain_text("Seeds that chose settings do not count: 100 to 115")
    expect(signed_in.locator("#curves[aria-busy]")).to_have_count(0)  # faint until then
    assert violations(signed_in) == []


def bounds(live: LiveService, sweep: str, look: int) -> str:
    """The service's own bounds of the last task."""
    with Client(live.url, TOKEN) as client:
        sequence = client.verdict(sweep).comparisons[-1].sequence
    return f"{sequence.low[look]:.3f} to {sequence.high[look]:.3f}"


def test_a_sweep_without_a_question_has_none(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep()
    live.train(0, 9600)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("figure canvas")).to_have_count(2)
    expect(signed_in.get_by_role("heading", name="Verdict")).to_be_hidden()
    assert not [path for path in live.trouble.requests if path.endswith("/verdict")]


def test_at_the_end_of_its_budget_it_says_what_more_would_do(
    signed_in: Page, live: LiveService
) -> None:
    sweep = asked(live, max_seeds=4)
    live.train(0, STEPS)
    look_at_all(live.store)
    signed_in.goto(f"{live.url}/sweeps/{sweep}")
    expect(signed_in.get_by_role("region", name="Verdict")).to_contain_text("more would decide")
    expect(signed_in.locator("article")).to_contain_text("100 % finished")
