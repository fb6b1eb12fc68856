"""The controls over the curves: what is chosen is read whole, and on a desk they are one row."""

import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import LiveService

pytestmark = pytest.mark.browser

SPARE_WIDTH = """select => {
  const alone = select.cloneNode();
  alone.append(select.selectedOptions[0].cloneNode(true));
  alone.style.width = "max-content";
  select.after(alone);
  const needed = alone.getBoundingClientRect().width;
  alone.remove();
  return select.getBoundingClientRect().width - needed;
}"""


@pytest.fixture
def sweep_page(signed_in: Page, live: LiveService) -> Page:
    sweep = live.add_sweep(environments=("Pendulum",))
    live.train(0, 9600)
    signed_in.set_viewport_size({"width": 1400, "height": 900})
    signed_in.goto(f"{live.url}/sweeps/{sweep.id}")
    expect(signed_in.locator("#legend li")).to_have_count(2)
    return signed_in


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("band", ["std", "ci95", "iqr", "none"]),
        ("x", ["timesteps", "updates", "jacobians", "seconds"]),
    ],
)
def test_the_choice_of_a_menu_is_not_cut(sweep_page: Page, name: str, values: list[str]) -> None:
    menu = sweep_page.locator(f"#controls [name={name}]")
    for value in values:
        menu.select_option(value)
        assert menu.evaluate(SPARE_WIDTH) > -1, value


def test_on_a_desk_they_are_one_row(sweep_page: Page) -> None:
    tops = sweep_page.locator("#controls").evaluate(
        "form => [...form.children].map((each) => each.getBoundingClientRect().bottom)"
    )
    assert max(tops) - min(tops) < 5
