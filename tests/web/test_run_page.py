"""A run's page, and runs and sweeps side by side."""

import re
from dataclasses import replace

import pytest
from playwright.sync_api import Locator, Page, expect

from service.model.environment import environment_facts
from service.model.sweep import Sweep
from tests.web.live_service import LiveService
from tests.web.test_accessibility import violations
from tests.web.test_sweep_page import state

pytestmark = pytest.mark.browser


@pytest.fixture
def sweep(live: LiveService) -> Sweep:
    sweep = live.add_sweep(environments=("Pendulum",))
    live.train(0, 9600)
    return sweep


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_run_s_curves_grow(signed_in: Page, live: LiveService, sweep: Sweep, scheme: str) -> None:
    signed_in.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
    signed_in.goto(f"{live.url}/runs/{sweep.id}-5")
    expect(signed_in.get_by_role("heading", level=1)).to_have_text(
        "hybrid-ddpg in Pendulum, seed 1"
    )
    returns = signed_in.get_by_role("figure", name="Return")
    returns.get_by_text("View as table").click()
    rows = returns.locator("tbody tr")
    expect(rows).to_have_count(12)
    live.train(9600, 12_000)
    expect(rows).to_have_count(15)
    expect(signed_in.locator("#percent")).to_have_text("60 %")
    expect(signed_in.get_by_role("figure", name="Losses").locator("canvas")).to_be_visible()
    signed_in.get_by_label("Over").select_option("updates")
    expect(rows.first.get_by_role("rowheader")).to_have_text("400")
    assert state(signed_in) == {"x": ["updates"], "table": ["Return"]}
    assert violations(signed_in) == []
    assert signed_in.get_by_role("link", name=sweep.name).get_attribute("href") == (
        f"/sweeps/{sweep.id}"
    )


def test_a_run_that_does_not_train_yet_says_that_kernels_compile(
    signed_in: Page, live: LiveService
) -> None:
    sweep = live.add_sweep(environments=("Pendulum",))
    live.train(0, 0)  # claimed, and nothing heard of it but that its worker lives
    signed_in.goto(f"{live.url}/runs/{sweep.id}-5")
    status = signed_in.locator("#status")
    expect(status).to_contain_text("running, compiling or loading kernels, submitted")
    live.train(0, 1600)
    expect(status).to_contain_text("running, submitted")
    live.train(1600, 20_000)
    expect(status).to_contain_text("succeeded, took")


def test_a_failed_run_tells_why(signed_in: Page, live: LiveService, sweep: Sweep) -> None:
    live.fail("Traceback ...\nValueError: <b>no</b>")
    signed_in.goto(f"{live.url}/runs/{sweep.id}-4")
    expect(signed_in.locator("#reason")).to_contain_text("ValueError: <b>no</b>")
    attempt = signed_in.locator("#attempts li")
    expect(attempt).to_contain_text("failed on test")
    expect(attempt.locator("pre").first).to_contain_text("Traceback ...")
    expect(signed_in.get_by_role("button", name="Cancel run")).to_be_hidden()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_log_grows_while_the_run_trains(
    signed_in: Page, live: LiveService, sweep: Sweep, scheme: str
) -> None:
    signed_in.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
    signed_in.goto(f"{live.url}/runs/{sweep.id}-0")
    log = signed_in.get_by_label("Log of the worker")
    expect(signed_in.locator("#attempts li")).to_contain_text("running on test")
    expect(log).to_be_hidden()
    live.print("<b>one</b>\n")
    expect(log).to_have_text("<b>one</b>\n")
    lines = "".join(f"line {number}\n" for number in range(200))
    live.print(lines)
    expect(log).to_contain_text("line 199")
    assert log.evaluate("log => log.scrollTop + log.clientHeight >= log.scrollHeight - 1")
    log.evaluate("log => log.scrollTo(0, 0)")
    live.print(f"{lines}the last\n")
    expect(log).to_contain_text("the last")
    assert log.evaluate("log => log.scrollTop") == 0
    assert violations(signed_in) == []
    live.train(9600, 20_000)
    expect(signed_in.locator("#attempts li")).to_contain_text("succeeded on test")
    expect(log).to_contain_text("the last")


def test_what_the_workers_of_other_runs_print_is_not_asked_for(
    signed_in: Page, live: LiveService, sweep: Sweep
) -> None:
    signed_in.goto(f"{live.url}/runs/{sweep.id}-5")  # of the second cohort
    expect(signed_in.locator("#attempts li")).to_contain_text("running on test")
    live.print("of the first cohort\n")
    live.train(9600, 10_400)  # is told after it
    expect(signed_in.locator("#percent")).to_have_text("52 %")
    expect(signed_in.get_by_label("Log of the worker")).to_be_hidden()


def test_a_run_is_cancelled_on_its_page(signed_in: Page, live: LiveService, sweep: Sweep) -> None:
    signed_in.goto(f"{live.url}/runs/{sweep.id}-0")
    signed_in.get_by_role("button", name="Cancel run").click()
    signed_in.get_by_role("button", name="Cancel the run").click()
    expect(signed_in.locator("#status")).to_contain_text("cancelling")
    assert live.store.cancelling_runs() == {f"{sweep.id}-0"}


def test_sweeps_are_compared(signed_in: Page, live: LiveService, sweep: Sweep) -> None:
    other = live.add_sweep("second look", (("hybrid-ddpg", 1.0, 0.0),), ("Pendulum",), seeds=3)
    live.train(0, 9600)
    signed_in.goto(f"{live.url}/compare?sweep={sweep.id}")
    legend = signed_in.locator("#legend li")
    expect(legend).to_have_count(2)
    signed_in.get_by_label("Add").select_option(other.id)
    expect(legend).to_have_count(3)
    expect(legend.last).to_contain_text("hybrid-ddpg · second look")
    differing = signed_in.locator("#differences .differs")
    expect(differing.filter(has_text="seeds")).to_have_text(re.compile(r"seeds\s*4\s*3"))
    expect(signed_in.locator("#differences")).not_to_contain_text("timesteps")
    signed_in.get_by_label("show equal ones, too").check()
    expect(signed_in.locator("#differences")).to_contain_text("timesteps")
    assert violations(signed_in) == []
    signed_in.get_by_role("button", name="Remove second look").click()
    expect(legend).to_have_count(2)


def test_runs_are_compared(signed_in: Page, live: LiveService, sweep: Sweep) -> None:
    signed_in.goto(f"{live.url}/compare?run={sweep.id}-0&run={sweep.id}-4")
    expect(signed_in.locator("#legend li")).to_have_count(2)
    figure = signed_in.get_by_role("figure", name="Pendulum")
    expect(figure.locator("canvas")).to_be_visible()
    expect(figure).to_contain_text("Mean, n = 1 seed. 0 is the random policy (return ")
    signed_in.get_by_role("radio", name="raw").check()
    expect(figure).to_contain_text("Mean, n = 1 seed. Raw, undiscounted returns.")
    expect(signed_in.locator("#differences .differs").first).to_have_text(
        re.compile(r"algorithm\s*ddpg\s*hybrid-ddpg")
    )


def test_the_catalogue_shows_audits_and_settings(signed_in: Page, live: LiveService) -> None:
    signed_in.get_by_role("link", name="Catalogue").click()
    expect(signed_in.locator("#environments tbody").first).to_contain_text("passed")
    expect(signed_in.locator("#environments")).to_contain_text("Acrobot")
    card = signed_in.get_by_role("article").filter(
        has=signed_in.get_by_text("hybrid-ddpg", exact=True)
    )
    parameters = signed_in.get_by_role("region", name="List of parameters")
    expect(parameters).to_contain_text(re.compile(r"Pendulum\s*gravity\s*10 m/s\^2\s*0 to 100"))
    expect(parameters.get_by_text("every environment")).to_have_count(2)
    card.get_by_text("Presets").click()
    expect(card.get_by_role("region", name="Presets of hybrid-ddpg")).to_contain_text("Pendulum")
    assert violations(signed_in) == []


def test_the_catalogue_describes_and_draws_every_task(
    signed_in: Page, live: LiveService, monkeypatch: pytest.MonkeyPatch
) -> None:
    facts = replace(environment_facts("Acrobot"), description="<b>Two</b> *links*.\n\n    x = 1")
    monkeypatch.setattr("service.api.routes.catalogue.known_environments", lambda: [facts])
    signed_in.goto(f"{live.url}/catalogue")
    card = signed_in.locator("#pictures article")
    expect(card).to_have_count(1)
    expect(card.locator("p").first).to_have_text("<b>Two</b> links.")
    expect(card.locator("em")).to_have_text("links")
    card.get_by_text("Definition").click()
    expect(card.locator("pre")).to_have_text("x = 1")
    picture = card.get_by_role("img", name="Acrobot at a start")
    expect(picture).to_be_visible()
    assert len(colours(picture)) > 1
    assert violations(signed_in) == []


def test_a_task_that_cannot_be_drawn_says_so(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    live.trouble.failing["/api/v1/environments/Acrobot/picture"] = 503
    signed_in.goto(f"{live.url}/catalogue")
    card = signed_in.locator("#pictures article").filter(has_text="Acrobot")
    expect(card).to_contain_text("The database is on holiday.")
    expect(signed_in.get_by_role("img", name="Pendulum at a start")).to_be_visible()
    assert all("503" in complaint for complaint in complaints)
    complaints.clear()


def colours(canvas: Locator) -> set[int]:
    """The colours of a canvas's pixels, each as one number."""
    script = """canvas => {
      const { width, height } = canvas;
      const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
      return [...new Set(new Uint32Array(data.buffer))];
    }"""
    return set(canvas.evaluate(script))


def test_the_parameters_of_a_runs_task_are_shown_and_its_returns_scaled(
    signed_in: Page, live: LiveService
) -> None:
    task = "Pendulum(gravity=9.81, process_noise=0.1)"
    sweep = live.add_sweep(environments=(task,))
    live.train(0, 4000)
    signed_in.goto(f"{live.url}/runs/{sweep.id}-0")
    parameters = signed_in.locator("#parameters div")
    expect(parameters.filter(has_text="gravity")).to_have_text("gravity9.81 m/s^2 given")
    expect(parameters.filter(has_text="length")).to_have_text("length1 m")
    expect(parameters.filter(has_text="process_noise")).to_have_text("process_noise0.1 given")
    expect(parameters).to_have_count(5)
    scaled = signed_in.locator("#key-figures div").filter(has_text=re.compile("^normalised"))
    expect(scaled).not_to_contain_text("–")
    assert violations(signed_in) == []


def test_the_score_comes_first_and_the_sweep_has_its_name(
    signed_in: Page, live: LiveService
) -> None:
    learners = (("ddpg", 0.0, 0.0), ("hybrid-ddpg", 0.1, 0.1))
    sweep = live.add_sweep("morning coffee", learners, environments=("Pendulum",), seeds=3)
    live.train(0, 4000)
    signed_in.goto(f"{live.url}/runs/{sweep.id}-4")
    expect(signed_in.get_by_role("link", name="morning coffee")).to_be_visible()
    figures = signed_in.locator("#key-figures")
    expect(figures.locator("dt").first).to_have_text("Score, normalised")
    expect(figures).to_contain_text("end not reached")
    expect(figures).to_contain_text("Processor time of training")
    live.train(4000, 20_000)
    expect(figures.locator("dd").first).to_contain_text("0.")
    settings = signed_in.locator("#settings")
    expect(settings.locator("div").filter(has_text="noise").first).to_contain_text("0.2")
    signed_in.get_by_label("Seed of this entry").select_option("2, succeeded")
    signed_in.wait_for_url(f"{live.url}/runs/{sweep.id}-5")
    expect(signed_in.get_by_role("heading", level=1)).to_contain_text("seed 2")


def test_a_run_without_a_measurement_says_what_it_waits_for(
    signed_in: Page, live: LiveService
) -> None:
    sweep = live.add_sweep()
    signed_in.goto(f"{live.url}/runs/{sweep.id}-0")
    phase = signed_in.locator("#loading")
    expect(phase).to_contain_text("Waits for a worker")
    live.train(0, 400)
    expect(phase).to_contain_text("Loading or compiling")
    live.train(400, 1600)
    expect(phase).to_be_hidden()
