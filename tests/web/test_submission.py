"""The form that submits a sweep: what it says before, what it refuses, what it sends."""

import json
import re
from typing import Any
from urllib.parse import quote

import pytest
from playwright.sync_api import Page, expect

from algorithms.presets import preset
from tests.web.live_service import LiveService
from tests.web.test_accessibility import violations

pytestmark = pytest.mark.browser


def test_a_sweep_is_counted_and_submitted_once(signed_in: Page, live: LiveService) -> None:
    signed_in.get_by_role("button", name="New sweep").click()
    form = signed_in.locator("#submission-form")
    expect(form.get_by_label("Name")).to_be_focused()
    expect(form.locator("#estimate")).to_have_text(
        "Choose at least one algorithm and one environment."
    )
    expect(form.get_by_role("button", name="Submit")).to_be_disabled()
    form.get_by_label("Name").fill("from the form")
    form.locator("[name=algorithm][value=ddpg]").check()
    form.locator("[name=algorithm][value=hybrid-ddpg]").check()
    form.get_by_label("Weights w1, w2").first.fill("0.1, 0.1; 1, 0")
    form.locator("[name=environment][value=Pendulum]").check()
    form.get_by_label("Seeds").fill("3, 5")
    form.get_by_label("Timesteps of a run").fill("4000")
    expect(form.locator("#estimate")).to_contain_text("6 runs, 24,000 timesteps")
    form.get_by_text("What will run").click()
    expect(form.get_by_role("region", name="Planned runs").locator("tbody tr")).to_have_count(3)
    assert violations(signed_in) == []
    keys: list[str] = []
    signed_in.on(
        "request", lambda sent: keys.extend(filter(None, [sent.headers.get("idempotency-key")]))
    )
    form.get_by_role("button", name="Submit").dblclick()
    signed_in.wait_for_url(f"{live.url}/sweeps/*")
    assert [len(key) for key in keys] == [32]
    (sweep,) = live.store.list_sweeps()
    assert sweep.name == "from the form"
    assert sweep.runs.total == 6
    assert sweep.request["algorithms"][1] == {
        "name": "hybrid-ddpg",
        "weights": [{"w1": 0.1, "w2": 0.1}, {"w1": 1, "w2": 0}],
    }
    signed_in.get_by_role("link", name="Submit another like it").click()
    expect(signed_in.get_by_label("Name", exact=True)).to_have_value("from the form")
    expect(signed_in.locator("#estimate")).to_contain_text("6 runs")


def test_who_cannot_learn_somewhere_takes_no_part_there(signed_in: Page, live: LiveService) -> None:
    signed_in.get_by_role("button", name="New sweep").click()
    mpc = signed_in.locator("[name=algorithm][value=mpc]")
    signed_in.locator("[name=environment][value=Acrobot]").check()
    expect(mpc).to_be_disabled()
    expect(signed_in.get_by_text("not in Acrobot: its reward has no gradient")).to_have_count(2)
    signed_in.locator("[name=environment][value=Pendulum]").check()
    mpc.check()
    signed_in.locator("[name=algorithm][value=ddpg]").check()
    signed_in.get_by_label("Share of the timesteps").fill("0.1")
    expect(signed_in.locator("#estimate")).to_contain_text("12 runs")  # (2 + 1) x 4 seeds
    signed_in.get_by_role("button", name="Submit").click()
    signed_in.wait_for_url(f"{live.url}/sweeps/*")
    (sweep,) = live.store.list_sweeps()
    expect(signed_in.locator("#summary")).to_contain_text(
        "2 learners in 2 environments: 3 curves × 4 seeds, 10 % of the timesteps"
    )
    assert sweep.request["scale"] == 0.1
    assert sweep.request["algorithms"][1] == {"name": "mpc", "environments": ["Pendulum"]}
    signed_in.get_by_role("link", name="Submit another like it").click()
    expect(signed_in.get_by_label("Share of the timesteps")).to_have_value("0.1")
    expect(signed_in.locator("#estimate")).to_contain_text("12 runs")


def test_what_is_to_be_known_is_said_before_it_is_sent(signed_in: Page, live: LiveService) -> None:
    draft = {
        "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg", "weights": {"w1": 0, "w2": 0}}],
        "environments": ["Pendulum"],
    }
    signed_in.goto(f"{live.url}/?new={quote(json.dumps(draft))}")
    notices = signed_in.locator("#submission-notices")
    expect(notices).to_contain_text(
        "algorithms[1] (hybrid-ddpg) has the weights (0, 0) in Pendulum"
    )
    expect(notices).to_contain_text("it is ddpg, bit for bit")
    signed_in.locator("#weights-hybrid-ddpg").fill("1, 0")
    expect(notices).to_be_hidden()


def test_an_entry_that_is_there_twice_is_said_beside_it(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    draft = {
        "algorithms": [
            {"name": "hybrid-ddpg", "weights": [{"w1": 0.1, "w2": 0}, {"w1": 1}, {"w1": 0.1}]}
        ],
        "environments": ["Pendulum"],
    }
    signed_in.goto(f"{live.url}/?new={quote(json.dumps(draft))}")
    fault = signed_in.locator(".learner .fault").first
    expect(fault).to_contain_text("is the same as algorithms[0].weights[0] in Pendulum")
    expect(signed_in.get_by_role("button", name="Submit")).to_be_disabled()
    assert all("422" in complaint for complaint in complaints)
    complaints.clear()


def test_errors_stand_beside_their_fields(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    draft = {
        "algorithms": [{"name": "hybrid-ddpg", "weights": {"w1": -1}, "config": {"noise": 7}}],
        "environments": ["Pendulum"],
        "seeds": 0,
    }
    signed_in.goto(f"{live.url}/?new={quote(json.dumps(draft))}")
    seeds = signed_in.locator("[data-fault=seeds]")
    expect(seeds.locator(".fault")).to_contain_text("greater than or equal to 1")
    expect(seeds.get_by_role("textbox")).to_have_attribute("aria-invalid", "true")
    weights = signed_in.locator(".learner .field").filter(has_text="Weights").first
    expect(signed_in.locator(".learner .fault").first).to_contain_text("greater than or equal to 0")
    seeds.get_by_role("textbox").fill("2")
    signed_in.locator("#weights-hybrid-ddpg").fill("")
    expect(weights).not_to_contain_text("greater")
    noise = signed_in.locator("#setting-hybrid-ddpg-noise")
    expect(noise.locator("xpath=..").locator(".fault")).to_contain_text("less than or equal to 1")
    assert all("422" in complaint for complaint in complaints)
    complaints.clear()


def test_a_form_that_cannot_be_made_says_why_and_is_made_at_the_next_try(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    live.trouble.failing["/api/v1/catalogue"] = 500
    signed_in.get_by_role("button", name="New sweep").click()
    fault = signed_in.locator("#submission-fault")
    expect(fault).to_have_text("The database is on holiday.")
    expect(signed_in.get_by_role("button", name="Submit")).to_be_disabled()
    del live.trouble.failing["/api/v1/catalogue"]
    signed_in.get_by_role("button", name="Close").click()
    signed_in.get_by_role("button", name="New sweep").click()
    expect(signed_in.locator("[name=algorithm][value=ddpg]")).to_be_visible()
    expect(fault).to_be_hidden()
    assert all("500" in complaint for complaint in complaints)
    complaints.clear()


def test_another_like_it_is_offered_once_it_is_known_what_it_is_like(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    sweep = live.add_sweep()
    path = f"/api/v1/sweeps/{sweep.id}"
    live.trouble.failing[path] = 500
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("#banner")).to_be_visible()
    again = signed_in.get_by_role("link", name="Submit another like it")
    expect(again).to_be_hidden()
    del live.trouble.failing[path]
    expect(again).to_have_attribute("href", re.compile("new="))
    complaints.clear()


def test_several_entries_of_an_algorithm_lists_and_labels_come_back(
    signed_in: Page, live: LiveService
) -> None:
    """What was submitted is what "another like it" shows, and what that submits."""
    body = {
        "name": "grid",
        "notes": "carried though the form does not show it",
        "tags": ["paper"],
        "algorithms": [
            {"name": "ddpg"},
            {"name": "ddpg", "label": "loud", "config": {"noise": [0.4, 0.5]}},
            {"name": "hybrid-ddpg", "weights": {"w1": [0.1, 1.0], "w2": 0.0}},
        ],
        "environments": ["Pendulum"],
        "seeds": 2,
        "timesteps": 1600,
    }
    headers = {"Content-Type": "application/json"}
    posted = signed_in.request.post(f"{live.url}/api/v1/sweeps", data=body, headers=headers).json()
    signed_in.goto(f"{live.url}/sweeps/{posted['id']}")
    signed_in.get_by_role("link", name="Submit another like it").click()
    estimate = signed_in.locator("#estimate")
    expect(estimate).to_contain_text("5 × 1 × 2 seeds = 10 runs, 16,000 timesteps")
    expect(signed_in.locator("#label-ddpg-2")).to_have_value("loud")
    expect(signed_in.locator("#setting-ddpg-2-noise")).to_have_value("0.4, 0.5")
    expect(signed_in.locator("#weights-hybrid-ddpg")).to_have_value("[0.1, 1], 0")
    assert violations(signed_in) == []
    signed_in.get_by_role("button", name="Submit", exact=True).click()
    signed_in.wait_for_url(re.compile("/sweeps/(?!" + posted["id"] + ")"))
    again, first = live.store.list_sweeps()
    assert again.request == first.request


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (
            {"question": {"compare": ["ours"], "with": "ddpg", "max_seeds": 40, "clip": 0.25}},
            "may become 80",
        ),
        ({"search": {"budget": 200_000}, "timesteps": 8000}, "of its budget of 200,000"),
    ],
)
def test_another_like_it_asks_and_searches_the_same(
    signed_in: Page, live: LiveService, asked: dict[str, Any], said: str
) -> None:
    """And says so: the form has no field for it."""
    body = {
        "algorithms": [{"name": "hybrid-ddpg", "label": "ours"}, {"name": "ddpg"}],
        "environments": ["Pendulum"],
        "seeds": 4,
        **asked,
    }
    headers = {"Content-Type": "application/json"}
    posted = signed_in.request.post(f"{live.url}/api/v1/sweeps", data=body, headers=headers).json()
    signed_in.goto(f"{live.url}/sweeps/{posted['id']}")
    signed_in.get_by_role("link", name="Submit another like it").click()
    expect(signed_in.locator("#submission-notices")).to_contain_text(said)
    signed_in.get_by_role("button", name="Submit", exact=True).click()
    signed_in.wait_for_url(re.compile("/sweeps/(?!" + posted["id"] + ")"))
    again, first = live.store.list_sweeps()
    assert {name: again.request[name] for name in asked} == asked
    assert again.search == first.search
    assert again.is_asking


def test_an_entry_is_added_and_removed(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    signed_in.get_by_role("button", name="New sweep").click()
    signed_in.locator("[name=algorithm][value=ddpg]").first.check()
    signed_in.locator("[name=environment][value=Pendulum]").check()
    signed_in.get_by_role("button", name="Another entry of ddpg").click()
    settings = signed_in.locator(".option", has=signed_in.locator("#setting-ddpg-2-noise"))
    settings.get_by_text("Settings", exact=True).click()
    noise = signed_in.locator("#setting-ddpg-2-noise")
    chosen = preset("ddpg", "Pendulum").config["noise"]
    expect(noise).to_have_attribute("placeholder", str(chosen))
    noise.fill("0.4, 0.5")
    expect(signed_in.locator("#estimate")).to_contain_text("3 × 1 × 4 seeds = 12 runs")
    signed_in.get_by_role("button", name="Remove this entry of ddpg").click()
    expect(signed_in.locator("#estimate")).to_contain_text("1 × 1 × 4 seeds = 4 runs")
    assert all("422" in each for each in complaints)  # the new entry was the first one's equal
    complaints.clear()
