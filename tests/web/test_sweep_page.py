"""A sweep's page: what a person does, and what the page then says."""

import csv
import io
import re
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from playwright.sync_api import Locator, Page, expect

from service.model.sweep import Sweep
from tests.web.live_service import LiveService
from tests.web.test_accessibility import violations

pytestmark = pytest.mark.browser

JSON = {"Content-Type": "application/json"}


@pytest.fixture
def sweep(live: LiveService) -> Sweep:
    """Halfway through."""
    sweep = live.add_sweep()
    live.train(0, 9600)
    return sweep


@pytest.fixture
def opened(signed_in: Page, live: LiveService, sweep: Sweep) -> Page:
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("figure canvas")).to_have_count(2)
    return signed_in


def panel(page: Page, environment: str) -> Locator:
    return page.get_by_role("figure", name=environment)


def table(page: Page, environment: str) -> Locator:
    summary = panel(page, environment).get_by_text("View as table")
    if not panel(page, environment).locator("details").evaluate("each => each.open"):
        summary.click()
    return panel(page, environment).get_by_role("table")


def caption(page: Page, environment: str = "Pendulum") -> Locator:
    return panel(page, environment).locator("figcaption")


def state(page: Page) -> dict[str, list[str]]:
    return parse_qs(urlsplit(page.url).query)


def test_head_says_what_and_how_far(opened: Page) -> None:
    expect(opened.get_by_role("heading", level=1)).to_have_text("first look")
    expect(opened.locator("#summary")).to_contain_text("2 learners × 2 environments × 4 seeds")
    expect(opened.locator("#percent")).to_have_text("48 %")
    expect(opened.get_by_role("list", name="Runs by status")).to_have_text("16 running")
    expect(opened).to_have_title("48 % · first look · d3pg")


def test_curves_grow_by_themselves(opened: Page, live: LiveService) -> None:
    rows = table(opened, "Pendulum").locator("tbody tr")
    expect(rows).to_have_count(12)
    expect(rows.last.get_by_role("rowheader")).to_have_text("9,600")
    live.train(9600, 20_000)
    expect(rows).to_have_count(25)
    expect(opened.locator("#counts")).to_have_text("16 succeeded")
    expect(opened.get_by_role("button", name="Cancel sweep")).to_be_hidden()


def test_table_has_the_service_s_numbers(opened: Page, live: LiveService, sweep: Sweep) -> None:
    answer = opened.request.get(f"{live.url}/api/v1/sweeps/{sweep.id}/curves").json()
    curve = answer["panels"][1]["curves"][0]
    cells = table(opened, "Pendulum").locator("tbody tr").last.get_by_role("cell")
    expect(cells.first).to_be_visible()
    shown = [float(text.replace("−", "-")) for text in cells.all_inner_texts()[:4]]
    assert shown == pytest.approx(
        [curve["mean"][-1], curve["low"][-1], curve["high"][-1], curve["n"][-1]], rel=5e-4
    )


def test_captions_and_definition_say_what_is_shown(opened: Page, live: LiveService) -> None:
    expect(caption(opened)).to_contain_text("Mean ± one standard deviation (ddof 1), n = 4 seeds.")
    expect(caption(opened)).to_contain_text("0 is the random policy (return −1,225, 95 % interval")
    expect(opened.locator("#definition")).to_contain_text("no smoothing")
    opened.get_by_label("Band").select_option("ci95")
    expect(caption(opened)).to_contain_text("95 % confidence interval (Student’s t)")
    expect(opened.locator("#definition")).to_contain_text("95 % confidence interval")
    opened.get_by_label("Band").select_option("none")
    expect(caption(opened)).to_contain_text("Mean, n = 4 seeds.")
    live.diverge(seed=1)
    live.train(9600, 12_000)
    expect(caption(opened, "MassPoint")).to_contain_text("n = 3 to 4 seeds")


def test_raw_returns_and_back(opened: Page) -> None:
    last = table(opened, "Pendulum").locator("tbody tr").last.get_by_role("cell").first
    expect(last).to_contain_text(re.compile(r"^0\.\d+"))
    opened.get_by_role("radio", name="raw").check()
    expect(last).to_contain_text(re.compile(r"^−\d{3}"))
    expect(caption(opened)).to_contain_text("Raw, undiscounted returns.")
    assert state(opened) == {"scale": ["raw"], "table": ["Pendulum"]}


def test_normalised_waits_for_the_random_policy(signed_in: Page, live: LiveService) -> None:
    live.measure_random = lambda environment: None  # type: ignore[method-assign]
    sweep = live.add_sweep()
    live.train(0, 4000)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(caption(signed_in)).to_contain_text("The random policy has not been measured yet")


def test_diagnostics_have_no_normalised_scale(opened: Page) -> None:
    metric = opened.get_by_label("Metric")
    expect(metric.locator("option")).to_have_text(["return_mean", "return_history", "critic_loss"])
    metric.select_option("critic_loss")
    expect(opened.get_by_role("radio", name="raw")).to_be_disabled()
    expect(opened.locator("#definition")).to_contain_text("critic_loss")
    expect(caption(opened)).not_to_contain_text("random")


def test_metrics_are_offered_as_they_come(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep()
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    options = signed_in.get_by_label("Metric").locator("option")
    expect(options).to_have_count(2)
    live.train(0, 4000)
    expect(options).to_have_count(3)


def test_times_grow_older_by_themselves(signed_in: Page, live: LiveService) -> None:
    sweep = live.add_sweep()
    signed_in.clock.install()
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    submitted = signed_in.locator("#summary time")
    expect(submitted).to_have_text("just now")
    signed_in.clock.fast_forward("01:40")
    expect(submitted).to_have_text("1 min ago")


def test_a_band_below_zero_leaves_a_logarithmic_axis_logarithmic(opened: Page) -> None:
    """The diagnostic falls towards 0, so mean minus deviation may be negative."""
    opened.get_by_label("Metric").select_option("critic_loss")
    opened.get_by_role("checkbox", name="y", exact=True).check()
    expect(caption(opened)).to_contain_text("Vertical axis logarithmic.")


def test_the_address_is_the_whole_view(opened: Page, live: LiveService) -> None:
    opened.get_by_label("Metric").select_option("return_history")
    opened.get_by_label("Over").select_option("updates")
    opened.get_by_label("Band").select_option("iqr")
    opened.get_by_role("checkbox", name="x", exact=True).check()
    opened.get_by_role("checkbox", name="y", exact=True).check()
    opened.get_by_role("checkbox", name="each seed").check()
    opened.get_by_label("Smoothing").fill("0.6")
    opened.get_by_role("checkbox", name=re.compile("^ddpg")).uncheck()
    expect(caption(opened)).to_contain_text("1 curve hidden.")
    assert state(opened) == {
        "metric": ["return_history"],
        "x": ["updates"],
        "band": ["iqr"],
        "logx": ["1"],
        "logy": ["1"],
        "smoothing": ["0.6"],
        "seeds": ["1"],
        "hide": ["ddpg"],
    }
    texts = caption(opened).inner_text()
    opened.reload()
    expect(caption(opened)).to_have_text(texts)
    expect(opened.get_by_label("Metric")).to_have_value("return_history")
    expect(opened.get_by_role("checkbox", name=re.compile("^ddpg"))).not_to_be_checked()
    opened.get_by_role("button", name="Reset view").click()
    expect(caption(opened)).to_contain_text("n = 4 seeds. 0 is the random policy")
    assert state(opened) == {}
    expect(opened.get_by_role("button", name="Reset view")).to_be_hidden()


def test_nonsense_in_the_address_is_ignored(
    signed_in: Page, live: LiveService, sweep: Sweep
) -> None:
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}?band=nobody&smoothing=7&scale=&hide=x&what=ever")
    expect(caption(signed_in)).to_contain_text("Mean ± one standard deviation (ddof 1), n = 4")


def test_legend_hides_and_solos(opened: Page) -> None:
    headers = table(opened, "Pendulum").get_by_role("columnheader")
    hybrid = opened.get_by_role("checkbox", name=re.compile("^hybrid-ddpg"))
    hybrid.uncheck()
    expect(headers.filter(has_text="hybrid-ddpg")).to_have_count(0)
    hybrid.check()
    expect(headers.filter(has_text="hybrid-ddpg")).to_have_count(1)
    opened.get_by_role("button", name="Show only hybrid-ddpg").click()
    expect(headers.filter(has_text=re.compile("^ddpg$"))).to_have_count(0)
    expect(opened.get_by_role("checkbox", name=re.compile("^ddpg"))).not_to_be_checked()
    opened.get_by_role("button", name="Show all").click()
    expect(headers.filter(has_text=re.compile("^ddpg$"))).to_have_count(1)


def test_hovering_one_panel_reads_all(opened: Page) -> None:
    box = panel(opened, "MassPoint").locator("canvas").bounding_box()
    assert box is not None
    opened.mouse.move(box["x"] + box["width"] / 3, box["y"] + box["height"] / 2)
    readouts = opened.locator(".readout")
    expect(readouts.first).to_contain_text("timesteps")
    expect(readouts.last).to_contain_text("timesteps")
    texts = readouts.all_inner_texts()
    steps = [text.splitlines()[0] for text in texts]
    assert steps[0] == steps[1]
    assert re.fullmatch(r"timesteps [\d,]+", steps[0])
    for text in texts:
        assert re.search(r"hybrid-ddpg\s+−?[\d.]+ ± [\d.]+\s+n 4", text)
    opened.mouse.move(5, 5)
    expect(readouts.first).to_be_hidden()
    expect(readouts.last).to_be_hidden()


def test_keyboard_reads_values(opened: Page) -> None:
    chart = opened.get_by_role("slider", name="Learning curves of Pendulum")
    chart.focus()
    opened.keyboard.press("ArrowRight")
    expect(chart).to_have_attribute("aria-valuenow", "800")
    opened.keyboard.press("End")
    expect(chart).to_have_attribute("aria-valuenow", "9600")
    expect(chart).to_have_attribute(
        "aria-valuetext", re.compile(r"^timesteps 9,600: ddpg .* ± .*, n 4; hybrid-ddpg .*, n 4$")
    )
    opened.keyboard.press("ArrowLeft")
    expect(chart).to_have_attribute("aria-valuenow", "8800")
    expect(panel(opened, "MassPoint").get_by_role("slider")).to_have_attribute(
        "aria-valuenow", "8800"
    )
    opened.keyboard.press("Escape")
    expect(chart).to_have_attribute("aria-valuetext", "no step chosen")


def test_smoothing_leaves_the_numbers_alone(opened: Page) -> None:
    rows = table(opened, "Pendulum").locator("tbody")
    expect(rows.get_by_role("cell").first).to_be_visible()
    exact = rows.inner_text()
    opened.get_by_label("Smoothing").fill("0.9")
    expect(caption(opened)).to_contain_text("Bold lines are smoothed for display")
    assert rows.inner_text() == exact


def test_downloads(opened: Page, live: LiveService, sweep: Sweep) -> None:
    opened.get_by_role("radio", name="raw").check()
    expect(caption(opened)).to_contain_text("Raw")
    with opened.expect_download() as downloading:
        opened.get_by_role("button", name="CSV").click()
    text = Path(downloading.value.path()).read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert len(rows) == 2 * 2 * 12
    answer = opened.request.get(
        f"{live.url}/api/v1/sweeps/{sweep.id}/curves?normalized=false"
    ).json()
    curve = answer["panels"][0]["curves"][0]
    assert [float(row["mean"]) for row in rows[:12]] == curve["mean"]
    assert {row["normalized"] for row in rows} == {"false"}
    for form in ("PNG", "SVG", "PDF"):
        with opened.expect_download() as downloading:
            opened.get_by_role("link", name=form).click()
        assert downloading.value.suggested_filename == f"sweep-{sweep.id}.{form.lower()}"
        assert "normalized=false" in downloading.value.url


def test_the_papers_figures_are_drawn_when_opened(
    opened: Page, live: LiveService, sweep: Sweep
) -> None:
    figures = opened.locator("#paper-figures")
    expect(figures.locator("img")).to_have_count(0)
    figures.get_by_text("The paper’s figures, from these runs").click()
    expect(figures.locator("figcaption")).to_have_text([re.compile("Figure 2"), re.compile("4")])
    assert state(opened) == {"figures": ["1"]}
    link = opened.get_by_role("link", name="Figure 4 as PDF")
    expect(link).to_have_attribute("href", f"/api/v1/sweeps/{sweep.id}/figures/4.pdf")
    expect(link).to_have_attribute("download", "")  # under the name that the service gives it
    picture = opened.get_by_alt_text("Figure 4 of the paper")
    picture.scroll_into_view_if_needed()
    expect(picture).to_have_js_property("complete", True, timeout=60_000)  # two are drawn
    assert picture.evaluate("each => each.naturalWidth") > 100


def test_failures_are_told_with_their_reasons(opened: Page, live: LiveService) -> None:
    live.fail("Traceback ...\nValueError: reward is not finite <b>here</b>")
    problems = opened.locator("#problems")
    expect(problems).to_contain_text("4 runs failed.")
    expect(problems).to_contain_text(
        "hybrid-ddpg in Pendulum, seed 0 and 3 more: ValueError: reward is not finite <b>here</b>"
    )
    live.diverge(seed=2)
    expect(problems).to_contain_text("4 runs failed, 1 run diverged.")


def test_cancelling_the_sweep(opened: Page, live: LiveService) -> None:
    live.add_sweep("bystander")
    opened.get_by_role("button", name="Cancel sweep").click()
    expect(opened.get_by_role("dialog")).to_contain_text("16 running runs will stop for good.")
    opened.keyboard.press("Escape")
    assert live.store.cancelling_runs() == set()
    opened.get_by_role("button", name="Cancel sweep").click()
    with opened.expect_response(re.compile("/cancel$")):
        opened.get_by_role("button", name="Cancel the sweep").click()
    assert len(live.store.cancelling_runs()) == 16


def test_a_sweep_is_paused_resumed_and_its_failures_retried(
    signed_in: Page, live: LiveService
) -> None:
    sweep = live.add_sweep(environments=("Pendulum",))
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    counts = signed_in.locator("#counts")
    signed_in.get_by_role("button", name="Pause").click()
    expect(counts).to_have_text("8 paused")
    expect(signed_in.locator("#remaining")).to_have_text("paused")
    expect(signed_in.get_by_role("button", name="Pause")).to_be_hidden()
    signed_in.get_by_role("button", name="Resume").click()
    expect(counts).to_have_text("8 queued")
    expect(signed_in.get_by_role("button", name="Resume")).to_be_hidden()
    live.train(0, 800)
    live.fail("ValueError: no")
    expect(counts).to_contain_text("4 failed")
    signed_in.get_by_role("button", name="Retry failed").click()
    expect(counts).to_contain_text("4 queued")
    expect(signed_in.locator("#problems")).to_be_hidden()


def test_the_score_table_sorts_and_marks_the_best(opened: Page, live: LiveService) -> None:
    rows = opened.locator("#score-table tbody tr")
    expect(rows).to_have_count(2)
    expect(rows.get_by_role("rowheader")).to_have_text(["ddpg", "hybrid-ddpg"])
    expect(rows.last).to_contain_text("n 0 of 4, 4 running")
    expect(rows.locator("strong")).to_have_count(0)
    live.train(9600, 20_000)
    expect(rows.last.locator("strong")).to_have_count(2)
    expect(rows.first).not_to_contain_text("running")
    opened.locator("#score-table").get_by_role("button", name="Pendulum").click()
    expect(rows.get_by_role("rowheader")).to_have_text(["hybrid-ddpg", "ddpg"])
    assert state(opened) == {"sort": ["Pendulum"]}
    with opened.expect_download() as downloading:
        opened.get_by_role("link", name="LaTeX").click()
    assert "tabular" in Path(downloading.value.path()).read_text(encoding="utf-8")


def test_a_cell_that_lacks_a_run_says_so_and_wins_nothing(opened: Page, live: LiveService) -> None:
    """Three of four seeds of ddpg are at their end: it comes last, whatever they reached."""
    live.diverge(seed=1)
    live.train(9600, 20_000)
    cell = opened.locator("#score-table tbody tr").first.get_by_role("cell").first
    expect(cell).to_contain_text("n 3 of 4, 1 diverged")
    expect(cell.locator("strong")).to_have_count(0)
    expect(opened.locator("#score-definition")).to_contain_text(
        "1 of 16 runs do not count (1 diverged)"
    )
    opened.locator("#score-table").get_by_role("button", name="MassPoint").click()
    expect(opened.locator("#score-table tbody th").last).to_have_text("ddpg")
    opened.get_by_text("Statistics: interquartile means").click()
    expect(opened.locator("#statistics-state")).to_contain_text(
        "ddpg in MassPoint: n 3 of 4, 1 diverged"
    )
    expect(opened.locator("#remaining")).to_have_text("ended, 15 of 16 runs finished")


def test_the_score_is_chosen_and_said(opened: Page, live: LiveService) -> None:
    live.train(9600, 20_000)
    definition = opened.locator("#score-definition")
    expect(definition).to_contain_text("last tenth of the run's timesteps")
    opened.get_by_text("Statistics: interquartile means").click()
    statistics = opened.locator("#statistics-state")
    expect(statistics).to_contain_text("last tenth of the run's timesteps")
    opened.get_by_role("combobox", name="Score").select_option("return_history")
    expect(definition).to_contain_text("mean of the latest 100 return_mean")
    expect(statistics).to_contain_text("mean of the latest 100 return_mean")
    assert state(opened) == {"score": ["return_history"], "statistics": ["1"]}
    link = opened.locator("#table-latex")
    expect(link).to_have_attribute("href", re.compile("score=return_history"))


def test_an_entry_is_one_row_and_one_line_whatever_its_presets(
    signed_in: Page, live: LiveService
) -> None:
    """Noise is 0.2 on MassPoint and 0.6 on Pendulum where an entry does not state it."""
    body = {
        "algorithms": [{"name": "ddpg"}, {"name": "ddpg", "config": {"noise": 0.1}}],
        "environments": ["MassPoint", "Pendulum"],
        "seeds": 2,
        "timesteps": 4000,
    }
    for environment in ("MassPoint", "Pendulum"):
        live.measure_random(environment)
    sweep = signed_in.request.post(f"{live.url}/api/v1/sweeps", data=body, headers=JSON).json()
    live.train(0, 4000)
    signed_in.goto(f"{live.url}/sweeps/{sweep['id']}")
    labels = ["ddpg", "ddpg noise=0.1"]
    expect(signed_in.locator("#legend li label")).to_have_text(
        [re.compile(f"^{label} 4 runs$") for label in labels]
    )
    expect(signed_in.locator("#score-table tbody th")).to_have_text(labels)
    signed_in.get_by_text("Statistics: interquartile means").click()
    expect(signed_in.locator("#statistics-state")).to_contain_text("Over MassPoint, Pendulum.")
    expect(signed_in.locator("#statistics")).to_contain_text("P(ddpg > ddpg noise=0.1)")
    for place in ("#legend", "#score-table", "#statistics"):
        lines = signed_in.locator(f"{place} svg.swatch line")
        expect(lines).to_have_count(2)
        dashes = lines.evaluate_all("all => all.map(each => each.getAttribute('stroke-dasharray'))")
        assert dashes == [None, "8 3.5"]
    signed_in.goto(f"{live.url}/sweeps/{sweep['id']}/runs")
    expect(signed_in.locator(".runs tbody tr").nth(2)).to_contain_text("ddpg noise=0.1")


def test_statistics_are_asked_for_when_opened(opened: Page, live: LiveService) -> None:
    live.train(9600, 20_000)
    opened.get_by_text("Statistics: interquartile means").click()
    means = opened.get_by_role("region", name="Interquartile mean").get_by_role("row")
    expect(means).to_have_count(2)
    expect(means.first).to_contain_text(re.compile(r"ddpg\s*0\.\d{3} \[0\.\d{3}, 0\.\d{3}\]"))
    expect(opened.get_by_role("figure", name="Performance profiles")).to_be_visible()
    expect(opened.locator("#statistics")).to_contain_text("P(ddpg > hybrid-ddpg)")
    assert state(opened) == {"statistics": ["1"]}


def test_a_theme_redraws_the_charts(opened: Page) -> None:
    canvas = opened.locator("figure canvas").first
    opened.emulate_media(color_scheme="light")
    light = canvas.evaluate("each => each.toDataURL()")
    opened.get_by_label("Theme").select_option("dark")
    dark = canvas.evaluate("each => each.toDataURL()")
    assert light != dark
    assert opened.evaluate("getComputedStyle(document.documentElement).colorScheme") == "dark"
    opened.reload()
    expect(opened.get_by_label("Theme")).to_have_value("dark")
    opened.get_by_label("Theme").select_option("system")
    opened.emulate_media(color_scheme="dark")
    expect(opened.locator("figure canvas")).to_have_count(2)


def test_colours_belong_to_algorithms(signed_in: Page, live: LiveService) -> None:
    for learners in ((("hybrid-ddpg", 0.1, 0.1), ("ddpg", 0.0, 0.0)), (("ddpg", 0.0, 0.0),)):
        sweep = live.add_sweep(learners=learners)
        signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
        line = (
            signed_in.locator("#legend li label")
            .filter(has_text=re.compile("^ddpg"))
            .locator("line")
        )
        expect(line).to_have_attribute("stroke", "#0072b2")


def test_variants_of_an_algorithm_differ_in_shade_and_dashes(
    signed_in: Page, live: LiveService
) -> None:
    learners = (("hybrid-ddpg", 0.1, 0.1), ("hybrid-ddpg", 0.01, 0.0))
    sweep = live.add_sweep(learners=learners, environments=("Pendulum",))
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    lines = signed_in.locator("#legend line")
    expect(lines).to_have_count(2)
    strokes = lines.evaluate_all("all => all.map((each) => each.getAttribute('stroke'))")
    dashes = lines.evaluate_all("all => all.map((each) => each.getAttribute('stroke-dasharray'))")
    assert strokes[0] != strokes[1]
    assert dashes[0] is None
    assert dashes[1] is not None


def test_an_unknown_sweep_says_so(
    signed_in: Page, live: LiveService, complaints: list[str]
) -> None:
    signed_in.goto(f"{live.url}/sweeps/000000000000")
    expect(signed_in.get_by_text("There is no sweep '000000000000'.")).to_be_visible()
    expect(signed_in.locator("#curves")).to_be_hidden()
    assert all("404" in complaint for complaint in complaints)
    complaints.clear()


MANY = (("ddpg", 0.0, 0.0), *(("hybrid-ddpg", w1, 0.0) for w1 in (0.01, 0.1, 1.0, 10.0)))


@pytest.fixture
def crowded(signed_in: Page, live: LiveService) -> Page:
    """A sweep of five entries, four of one algorithm."""
    sweep = live.add_sweep(learners=MANY, seeds=2)
    live.train(0, 9600)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("figure canvas")).to_have_count(2)
    return signed_in


def test_the_legend_finds_curves_and_keeps_the_highest(crowded: Page) -> None:
    expect(crowded.locator("#legend-step")).to_have_text("Latest, mean over tasks:")
    colours = crowded.locator("#legend line").evaluate_all(
        "all => all.map(each => each.getAttribute('stroke'))"
    )
    assert len(set(colours)) == 5
    crowded.get_by_label("Find curves").fill("w1=1")
    expect(crowded.locator("#legend-step")).to_contain_text("2 of 5 curves.")
    expect(caption(crowded)).to_contain_text("3 curves hidden.")
    crowded.get_by_label("Find curves").fill("")
    crowded.get_by_label("How many curves").select_option("3")
    expect(crowded.locator("#legend-step")).to_contain_text("3 of 5 curves.")
    assert state(crowded) == {"top": ["3"]}
    kept = crowded.locator("#legend line").evaluate_all(
        "all => all.map(each => each.getAttribute('stroke'))"
    )
    assert kept == colours  # stable under filtering


def test_the_legend_sorts_by_the_value_at_the_cursor(crowded: Page) -> None:
    crowded.get_by_label("Order of the legend").select_option("value")

    def values() -> list[float]:
        texts = crowded.locator("#legend .value").all_inner_texts()
        return [float(text.replace("−", "-")) for text in texts]

    assert values() == sorted(values(), reverse=True)
    chart = crowded.get_by_role("slider", name="Learning curves of Pendulum")
    chart.focus()
    crowded.keyboard.press("Home")
    expect(crowded.locator("#legend-step")).to_have_text("Pendulum, 800:")
    assert values() == sorted(values(), reverse=True)
    first = crowded.locator("#legend .value").first.inner_text()
    expect(chart).to_have_attribute("aria-valuetext", re.compile(re.escape(first[:4])))


def test_dragging_zooms_and_a_double_click_shows_all(opened: Page) -> None:
    box = panel(opened, "Pendulum").locator(".u-over").bounding_box()
    assert box is not None
    y = box["y"] + box["height"] / 2
    opened.mouse.move(box["x"] + box["width"] / 4, y)
    opened.mouse.down()
    opened.mouse.move(box["x"] + box["width"] / 2, y, steps=4)
    opened.mouse.up()
    expect(caption(opened)).to_contain_text("Axes have limits")
    asked = state(opened)
    assert float(asked["from"][0]) == pytest.approx(5000, rel=0.1)
    assert float(asked["to"][0]) == pytest.approx(10_000, rel=0.1)
    opened.mouse.dblclick(box["x"] + box["width"] / 2, y)
    expect(caption(opened)).not_to_contain_text("Axes have limits")
    assert state(opened) == {}


def test_the_y_axis_has_limits_when_asked(opened: Page) -> None:
    opened.get_by_label("Greatest y").fill("0.5")
    opened.get_by_label("Greatest y").press("Enter")
    expect(caption(opened)).to_contain_text("Axes have limits; what lies beyond")
    assert state(opened) == {"ymax": ["0.5"]}
    opened.get_by_role("checkbox", name="no outliers").check()
    expect(caption(opened)).to_contain_text("outliers, 2 % at either end")
    opened.reload()
    expect(opened.get_by_label("Greatest y")).to_have_value("0.5")


def test_a_figure_is_what_is_on_the_screen(opened: Page, live: LiveService, sweep: Sweep) -> None:
    opened.get_by_label("Metric").select_option("critic_loss")
    opened.get_by_role("checkbox", name="y", exact=True).check()
    opened.get_by_label("Smoothing").fill("0.6")
    opened.get_by_role("checkbox", name=re.compile("^ddpg")).uncheck()
    expect(caption(opened)).to_contain_text("1 curve hidden.")
    for form in ("png", "svg", "pdf", "data"):
        link = opened.locator(f"#download-{form}").get_attribute("href") or ""
        asked = parse_qs(urlsplit(link).query)
        assert asked["metric"] == ["critic_loss"]
        assert asked["logy"] == ["true"]
        assert asked["smoothing"] == ["0.6"]
        assert asked["entry"] == ["hybrid-ddpg"]
        assert opened.request.get(live.url + link).status == 200


def test_a_figure_is_built_with_a_preview(opened: Page, live: LiveService, sweep: Sweep) -> None:
    opened.get_by_text("A figure for a paper").click()
    preview = opened.locator("#figure-preview")
    expect(preview).to_have_attribute("src", re.compile("plot.svg"), timeout=60_000)
    opened.get_by_label("Width in columns").select_option("1")
    opened.get_by_label("Size of the font in points").fill("6")
    opened.get_by_label("Size of the font in points").press("Enter")
    opened.get_by_label("Name of hybrid-ddpg").fill("ours")
    opened.get_by_label("Name of hybrid-ddpg").press("Enter")
    opened.get_by_role("button", name="Up: hybrid-ddpg").click()
    opened.get_by_role("checkbox", name="title").uncheck()
    opened.locator("#figure-tasks").get_by_role("checkbox", name="MassPoint").uncheck()
    assert state(opened) == {
        "columns": ["1"],
        "font_size": ["6"],
        "name": ["hybrid-ddpg=ours"],
        "entry": ["hybrid-ddpg", "ddpg"],
        "title": ["0"],
        "task": ["Pendulum"],
    }
    expect(preview).to_have_attribute("src", re.compile("name=hybrid-ddpg%3Dours"))
    expect(opened.locator("#figure-state")).to_have_text("", timeout=60_000)
    expect(preview).to_have_js_property("naturalWidth", 312)  # 3.25 inches of 96 pixels
    link = opened.locator("#download-svg").get_attribute("href") or ""
    svg = opened.request.get(live.url + link).text()
    assert "ours" in svg
    assert "MassPoint" not in svg


def test_a_figure_that_cannot_be_drawn_says_why(opened: Page, complaints: list[str]) -> None:
    opened.get_by_text("A figure for a paper").click()
    opened.get_by_label("Width in inches").fill("0.1")
    opened.get_by_label("Width in inches").press("Enter")
    expect(opened.locator("#figure-state")).to_contain_text("width", timeout=60_000)
    assert all("422" in complaint for complaint in complaints)
    complaints.clear()


def test_many_pairs_are_a_matrix_with_a_reference(crowded: Page, live: LiveService) -> None:
    live.train(9600, 20_000)
    crowded.get_by_text("Statistics: interquartile means").click()
    improvement = crowded.get_by_role("region", name="Probability of improvement")
    matrix = improvement.locator("table.matrix")
    expect(matrix.locator("tbody tr")).to_have_count(5)
    expect(matrix.locator("tbody tr").first.locator("td").first).to_have_text("–")
    sentences = improvement.locator("table.intervals tr")
    expect(sentences).to_have_count(4)
    expect(sentences.first).to_contain_text("> ddpg)")
    differences = crowded.get_by_role("region", name="Paired differences in area")
    expect(differences.locator("tbody tr")).to_have_count(4)
    expect(differences.locator("thead th")).to_have_text(["MassPoint", "Pendulum"])
    expect(differences.locator("tbody td strong").first).to_contain_text("+0.")

    above = matrix.locator("tbody tr").nth(1).locator("td").first
    below = matrix.locator("tbody tr").first.locator("td").nth(1)
    assert float(above.inner_text()) == pytest.approx(1 - float(below.inner_text()), abs=0.011)
    crowded.get_by_label("compared with").focus()
    crowded.get_by_label("compared with").select_option("hybrid-ddpg w1=1")
    expect(sentences.first).to_contain_text("> hybrid-ddpg w1=1)")
    expect(differences.locator("tbody th").first).to_have_text("ddpg")
    expect(differences.locator("tbody td strong").first).to_contain_text("−0.")
    assert state(crowded) == {"statistics": ["1"], "reference": ["hybrid-ddpg w1=1"]}
    expect(crowded.get_by_label("compared with")).to_be_focused()
    assert violations(crowded) == []


def test_settings_are_drawn_against_the_score(crowded: Page, live: LiveService) -> None:
    live.train(9600, 20_000)
    maps = crowded.locator("#settings-maps")
    expect(maps.locator("circle")).to_have_count(5)
    expect(maps.get_by_role("img", name="Score by w1")).to_be_visible()
    maps.get_by_label("Task").select_option("Pendulum")
    expect(maps.locator("circle title").first).to_contain_text("ddpg: 0.")
    assert state(crowded) == {"map_task": ["Pendulum"]}
    assert violations(crowded) == []


def test_two_settings_are_a_heat_map(signed_in: Page, live: LiveService) -> None:
    grid = tuple(("hybrid-ddpg", w1, w2) for w1 in (0.1, 1.0) for w2 in (0.0, 0.01, 0.1))
    sweep = live.add_sweep(learners=grid, seeds=2, environments=("Pendulum",))
    live.train(0, 20_000)
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}?map=heat")
    rows = signed_in.locator("#map tbody tr")
    expect(rows).to_have_count(3)
    expect(rows.get_by_role("rowheader")).to_have_text(["0.1", "0.01", "0"])
    expect(rows.first.locator("td")).to_have_text([re.compile(r"0\.\d+")] * 2)
    signed_in.get_by_label("Drawn as").select_option("parallel")
    expect(signed_in.locator("#map polyline")).to_have_count(6)


def test_the_browser_tells_when_a_sweep_is_done(
    signed_in: Page, live: LiveService, sweep: Sweep
) -> None:
    """Also where the tab is hidden, so that the page itself fetches nothing."""
    signed_in.add_init_script(
        """globalThis.Notification = class {
          static requestPermission() { return Promise.resolve("granted"); }
          constructor(title, { body }) { document.body.dataset.told = `${title}: ${body}`; }
        };"""
    )
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    button = signed_in.get_by_role("button", name="Tell me when it is done")
    button.click()
    told = signed_in.get_by_role("button", name="Will tell you")
    expect(told).to_have_attribute("aria-pressed", "true")
    live.train(9600, 20_000)
    expect(signed_in.locator("body")).to_have_attribute("data-told", "first look: finished")
