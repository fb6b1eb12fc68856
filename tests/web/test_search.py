"""A search on a sweep's page: nothing without one, then it climbs, then it stands."""

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
WEIGHTS = [0.1, 0.2, 0.5, 1.0]


def searching(live: LiveService) -> str:
    """The id of a sweep that searches the weights of the hybrid: four entries, then two."""
    for task in TASKS:
        live.measure_random(task)
    with Client(live.url, TOKEN) as client:
        return client.submit({
            "name": "which weights?",
            "algorithms": [{"name": "hybrid-ddpg", "weights": {"w1": WEIGHTS, "w2": 0.0}}],
            "environments": TASKS,
            "seeds": 3,
            "timesteps": STEPS,
            "search": {"budget": 1_000_000},
        }).id  # fmt: skip


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_climbs_and_stands(signed_in: Page, live: LiveService, scheme: str) -> None:
    signed_in.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
    sweep = searching(live)
    signed_in.goto(f"{live.url}/sweeps/{sweep}")
    found = signed_in.get_by_role("region", name="Search", exact=True)
    expect(signed_in.locator("article")).to_contain_text("search among 4 learners × 2 environments")
    task = found.get_by_role("listitem").filter(has_text="Pendulum")
    expect(task).to_contain_text("rung 1 of 2: 4 entries to 6,400 timesteps")
    expect(task.locator("tbody tr").first).to_contain_text("9 on the way")
    live.train(0, 6400)
    look_at_all(live.store)
    expect(task).to_contain_text("rung 2 of 2: 2 entries to 20,000 timesteps")
    expect(task.locator("tbody tr").first).to_contain_text("9 on the way")
    expect(task.locator("tbody tr").last).to_contain_text("–")
    live.train(6400, STEPS)
    look_at_all(live.store)
    with Client(live.url, TOKEN) as client:
        [*_, answer] = client.search(sweep).tasks
    assert answer.winner is not None
    expect(task).to_contain_text(f"{answer.winner} is the best of 4: 0.")
    first = task.locator("tbody tr").first
    expect(first.get_by_role("rowheader")).to_have_text(answer.winner)
    expect(first.locator("strong")).to_have_count(2)
    expect(signed_in.get_by_role("heading", name="Scores", exact=True)).to_be_visible()
    expect(signed_in.locator("#statistics")).to_be_hidden()  # no test of what was chosen
    expect(found).to_contain_text("1,000,000,000 to 1,000,000,008), which no question takes")
    expect(signed_in.locator("#curves[aria-busy]")).to_have_count(0)  # faint until then
    assert violations(signed_in) == []


def test_a_sweep_that_searches_nothing_has_none(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep()
    live.train(0, 9600)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("figure canvas")).to_have_count(2)
    expect(signed_in.get_by_role("heading", name="Search", exact=True)).to_be_hidden()
    assert not [path for path in live.trouble.requests if path.endswith("/search")]
