"""Pictures of a verdict and of a search, while they form and when they stand.

    python -m tests.web.findings_pictures FOLDER

The runs are invented (`live_service`), the service and the browser are real. Each page is taken as
wide as a large screen, a small one and a telephone.
"""

import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Page, expect, sync_playwright

import hatch_build
from service.client import Client, SubmissionNotice
from service.queue.question_rounds import look_at_all
from tests.web.conftest import QUIET_FLAGS
from tests.web.live_service import TOKEN, LiveService

SIZES = {"wide": (1400, 900), "small": (1280, 720), "phone": (390, 844)}
TASKS = ["CartPole", "MassPoint", "Pendulum"]
STEPS = 20_000
QUESTION = {"compare": ["hybrid-ddpg", "td3"], "with": "ddpg", "batch": 4, "clip": 0.25,
            "max_seeds": 24}  # fmt: skip


def asked(live: LiveService) -> str:
    """The id of a question in three tasks, of two entries."""
    return submitted(
        live,
        name="does it help?",
        algorithms=[{"name": "ddpg"}, {"name": "hybrid-ddpg"}, {"name": "td3"}],
        seeds=4,
        question=QUESTION,
    )


def searched(live: LiveService) -> str:
    """The id of a search among six pairs of weights."""
    grid = {"w1": [0.1, 0.5, 1.0], "w2": [0.0, 0.1]}
    return submitted(
        live,
        name="which weights?",
        algorithms=[{"name": "hybrid-ddpg", "weights": grid}],
        seeds=2,
        search={"budget": 1_500_000},
    )


def submitted(live: LiveService, **fields: object) -> str:
    """The id of a sweep in all tasks."""
    for task in TASKS:
        live.measure_random(task)
    with Client(live.url, TOKEN) as client:
        return client.submit({"environments": TASKS, "timesteps": STEPS, **fields}).id


def forms(live: LiveService, looks: int) -> None:
    """Train what waits and look, some times over; then train half of what is asked for."""
    for _ in range(looks):
        live.train(0, STEPS)
        look_at_all(live.store)
    live.train(0, STEPS // 2)


def stands(live: LiveService) -> None:
    """Train until nothing more is asked for."""
    live.train(STEPS // 2, STEPS)
    while look_at_all(live.store):
        live.train(0, STEPS)


def take(page: Page, url: str, section: str, folder: Path, name: str) -> None:
    """Take the page from its top, and the section by itself, in every size."""
    for size, (width, height) in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        page.goto(url)
        expect(page.locator(section)).to_be_visible()
        expect(page.locator("figure canvas").first).to_be_visible()
        expect(page.locator("#curves[aria-busy]")).to_have_count(0)
        page.screenshot(path=folder / f"{name}-{size}.png")
        page.locator(section).screenshot(path=folder / f"{name}-{size}-section.png")


@contextmanager
def browser_page(live: LiveService) -> Iterator[Page]:
    """A signed-in page in Debian's Chromium."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium", args=QUIET_FLAGS.split()
        )
        page = browser.new_page()
        page.goto(live.signin_link)
        yield page
        browser.close()


def main(folder: Path) -> None:
    """Take all pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    hatch_build.bring_in(Path(__file__).parents[2] / hatch_build.VENDOR)
    warnings.simplefilter("ignore", SubmissionNotice)
    makers: dict[str, tuple[Callable[[LiveService], str], int]] = {
        "verdict": (asked, 3),
        "search": (searched, 1),
    }
    with tempfile.TemporaryDirectory() as data:
        live = LiveService(Path(data))
        with browser_page(live) as page:
            for section, (make, looks) in makers.items():
                url = f"{live.url}/sweeps/{make(live)}"
                forms(live, looks)
                take(page, url, f"#{section}", folder, f"{section}-forms")
                stands(live)
                take(page, url, f"#{section}", folder, f"{section}-stands")
        live.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
