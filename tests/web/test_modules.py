"""The scripts' own arithmetic, run where it will run: in the browser."""

from typing import Any

import pytest
from playwright.sync_api import Page

from service.analysis.figures.palette import BLUE, COLOURS, OTHERS, colour, shades

pytestmark = pytest.mark.browser


def call(page: Page, module: str, function: str, *arguments: Any) -> Any:
    """Call a function that a static module exports."""
    script = "async ([path, name, values]) => (await import(path))[name](...values)"
    return page.evaluate(script, [address(page, module), function, list(arguments)])


def address(page: Page, module: str) -> str:
    """Where a module is, under the version of the page's own script."""
    script = page.locator("script[type=module]").get_attribute("src") or ""
    return f"{script.rpartition('/pages/')[0]}/{module}.js"


def test_smoothing_is_the_debiased_average(signed_in: Page) -> None:
    values = [3.0, None, 1.0, 2.0]
    smoothed = call(signed_in, "charts/y_scale", "smooth", values, 0.5)
    # m_1 = 1.5, m_2 = 1.25, m_3 = 1.625 over 1 - 2^-k
    assert smoothed == [3.0, None, pytest.approx(1.25 / 0.75), pytest.approx(1.625 / 0.875)]
    assert call(signed_in, "charts/y_scale", "smooth", [7.0] * 5, 0.9) == pytest.approx([7.0] * 5)
    assert call(signed_in, "charts/y_scale", "smooth", values, 0) == values


def test_smoothing_averages_what_the_axis_shows(signed_in: Page) -> None:
    """On a logarithmic axis two values have their geometric mean in the middle."""
    scale = call(signed_in, "charts/y_scale", "yScale", [1.0, 100.0], True)
    assert scale["scale"] == "log"
    smoothed = call(signed_in, "charts/y_scale", "smooth", [1.0, 100.0], 0.5, scale)
    assert smoothed == [1.0, pytest.approx(100 ** (2 / 3))]
    signed = call(signed_in, "charts/y_scale", "yScale", [-1.0, 1.0], True)
    assert signed["scale"] == "symlog"
    smoothed = call(signed_in, "charts/y_scale", "smooth", [-5.0, 5.0, -5.0], 0.9, signed)
    assert all(-5.0 <= value <= 5.0 for value in smoothed)


def test_a_band_below_zero_leaves_a_logarithmic_axis_logarithmic(signed_in: Page) -> None:
    scale = call(signed_in, "charts/y_scale", "yScale", [0.5, 0.02], True)
    curve = {"low": [-0.1, None, 0.015], "high": [1.0, None, 0.03]}
    assert scale["scale"] == "log"
    cut = call(signed_in, "charts/y_scale", "withinAxis", curve, scale)
    assert cut == {"low": [0.01, None, 0.015], "high": [1.0, None, 0.03]}


def test_what_presets_say_where(signed_in: Page) -> None:
    def told(*values: tuple[str, str]) -> Any:
        shown = [{"name": name, "text": text} for name, text in values]
        return call(signed_in, "submit/values", "presetText", shown, "0.2")

    assert told() == "0.2"
    assert told(("MassPoint", "0.2"), ("CartPole", "0.2")) == "0.2"
    assert told(("MassPoint", "0.2"), ("Pendulum", "0.6")) == "0.2 in MassPoint; 0.6 in Pendulum"


@pytest.mark.parametrize(
    ("function", "value", "text"),
    [
        ("number", -1225.43, "−1,225"),
        ("number", 0.000012345, "1.23E−5"),
        ("number", None, "–"),
        ("tick", 20_000, "20k"),
        ("tick", -1500, "−1.5k"),
        ("tick", 2_500_000, "2.5M"),
        ("percent", 0.999, "99 %"),
        ("percent", 0.29, "29 %"),
        ("duration", 3725, "1 h 2 min"),
        ("duration", 0.2, "0 s"),
        ("duration", 180, "3 min"),
        ("duration", 97_200, "1 d 3 h"),
        ("remaining", 4, "a few seconds left"),
        ("remaining", 111, "about 1 min 50 s left"),
        ("remaining", 3599, "about 1 h left"),
        ("remaining", None, ""),
    ],
)
def test_format(signed_in: Page, function: str, value: float | None, text: str) -> None:
    assert call(signed_in, "texts/format", function, value) == text


def test_bands_in_words(signed_in: Page) -> None:
    assert call(signed_in, "texts/format", "withBand", 0.8421, 0.8111, 0.8731) == "0.842 ± 0.031"
    assert call(signed_in, "texts/format", "withBand", 0.84, -0.5, 0.9) == "0.84 (−0.5 to 0.9)"
    assert call(signed_in, "texts/format", "withBand", -3.0, None, None) == "−3"


@pytest.mark.parametrize(
    ("x", "label"), [("seconds", "processor seconds of training"), ("timesteps", "timesteps")]
)
def test_axes_say_what_they_are_over(signed_in: Page, x: str, label: str) -> None:
    assert call(signed_in, "parts/view", "xLabel", x) == label


def test_what_a_run_cost_is_no_diagnostic_of_it(signed_in: Page) -> None:
    names = ["timestep", "seconds", "compile_seconds", "critic_loss"]
    columns = {name: [1.0] for name in names}
    charts = call(signed_in, "run/diagnostics", "chartsOf", columns)
    assert [name for chart in charts for name in chart["names"]] == ["critic_loss"]


def test_colours_are_those_of_the_figures_in_files(signed_in: Page) -> None:
    for algorithm in [*COLOURS, "somebody-s-own", "td3", "ppo"]:
        ours = call(signed_in, "parts/palette", "algorithmColour", algorithm)
        assert ours == colour(algorithm).lower()


def test_shades_are_those_of_the_figures_in_files(signed_in: Page) -> None:
    signed_in.emulate_media(color_scheme="light")
    for base in [*COLOURS.values(), *OTHERS]:
        for count in (1, 2, 7):
            ours = call(signed_in, "parts/palette", "shades", base, count)
            assert [channels(each) for each in ours] == [
                pytest.approx(channels(each), abs=1) for each in shades(base, count)
            ]


def channels(colour: str) -> list[int]:
    return [int(colour[place : place + 2], 16) for place in (1, 3, 5)]


def test_entries_that_differ_in_one_number_are_shades_in_its_order(signed_in: Page) -> None:
    values = [0.2, 0.05, 0.4]
    entries = [
        {"label": f"ddpg noise={each}", "algorithm": "ddpg", "stated": {"noise": each}}
        for each in values
    ]
    script = """async ([path, entries]) => {
      const { identities } = await import(path);
      return [...identities(entries).values()].map(({ colour }) => colour);
    }"""
    shown = signed_in.evaluate(script, [address(signed_in, "parts/identity"), entries])
    by_value = dict(zip(sorted(values), shades(BLUE, 3), strict=True))
    assert [channels(each) for each in shown] == [
        pytest.approx(channels(by_value[each]), abs=1) for each in values
    ]


def test_no_two_entries_share_colour_and_dash(signed_in: Page) -> None:
    """Twelve of one algorithm, and others' algorithms that happen on the same colour."""
    others = [name for name in map("algorithm-{}".format, range(60)) if colour(name) == BLUE]
    entries = [{"label": f"ddpg {k}", "algorithm": "ddpg"} for k in range(12)]
    entries += [{"label": name, "algorithm": name} for name in others]
    assert others
    script = """async ([path, entries]) => {
      const { identities } = await import(path);
      return [...identities(entries).values()].map(({ colour, dash }) => `${colour} ${dash}`);
    }"""
    shown = signed_in.evaluate(script, [address(signed_in, "parts/identity"), entries])
    assert len(set(shown)) == len(entries)


def test_grids_are_joined_without_inventing_values(signed_in: Page) -> None:
    script = """async (path) => {
      const { placement, union } = await import(path);
      const xs = union([[1, 3, 5], [2, 3]]);
      return [xs, placement([2, 3], xs)([null, 7]).map((value) => value ?? String(value))];
    }"""
    assert signed_in.evaluate(script, address(signed_in, "charts/layers")) == [
        [1, 2, 3, 5],
        [None, "null", 7, None],
    ]


def test_logarithmic_ticks_are_round_and_apart(signed_in: Page) -> None:
    script = """async (path) => {
      const { roundTicks } = await import(path);
      return roundTicks(0.03, 20, (value) => 100 * Math.log10(value), 25);
    }"""
    ticks = signed_in.evaluate(script, address(signed_in, "charts/axes"))
    assert ticks == [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20]


def test_markdown_is_read_as_docstrings_write_it(signed_in: Page) -> None:
    text = (
        "Pendulum: a *rod* that\nturns, see `step`.\n\n    r = -x**2\n\n    s = 2 * a * b\n\n"
        "Glossary:\n    x   place\n    y   height\n\n"
        "- one **item**\n  goes on\n- [two](https://a.example/x)\n\n1. first\n2. second\n\n"
        "## A heading\n```python\n# no heading\n```\nthe end"
    )
    assert call(signed_in, "texts/markdown", "markdown", text) == [
        {
            "kind": "paragraph",
            "spans": [
                {"kind": "text", "text": "Pendulum: a "},
                {"kind": "emphasis", "text": "rod"},
                {"kind": "text", "text": " that turns, see "},
                {"kind": "code", "text": "step"},
                {"kind": "text", "text": "."},
            ],
        },
        {"kind": "code", "text": "r = -x**2\n\ns = 2 * a * b"},
        {"kind": "paragraph", "spans": [{"kind": "text", "text": "Glossary:"}]},
        {"kind": "code", "text": "x   place\ny   height"},
        {
            "kind": "list",
            "isOrdered": False,
            "items": [
                [
                    {"kind": "text", "text": "one "},
                    {"kind": "strong", "text": "item"},
                    {"kind": "text", "text": " goes on"},
                ],
                [{"kind": "link", "text": "two", "address": "https://a.example/x"}],
            ],
        },
        {
            "kind": "list",
            "isOrdered": True,
            "items": [[{"kind": "text", "text": name}] for name in ("first", "second")],
        },
        {"kind": "heading", "spans": [{"kind": "text", "text": "A heading"}]},
        {"kind": "code", "text": "# no heading"},
        {"kind": "paragraph", "spans": [{"kind": "text", "text": "the end"}]},
    ]


@pytest.mark.parametrize(
    "text",
    [
        "<img src=x onerror=alert(1)>",
        "[a](javascript:alert(1)) and [b](data:text/html,x)",
        "a * b * c, 2**3**4 and names_of_things_",
        "`not closed, **not closed, *not closed",
    ],
)
def test_what_is_no_markdown_stays_text(signed_in: Page, text: str) -> None:
    found = call(signed_in, "texts/markdown", "markdown", text)
    assert found == [{"kind": "paragraph", "spans": [{"kind": "text", "text": text}]}]
