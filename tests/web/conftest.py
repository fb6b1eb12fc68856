"""A Chromium with a signed-in page of a running service; it must not complain."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

import hatch_build
from tests.web.live_service import LiveService

PATIENCE_MILLISECONDS = 15_000  # on a machine that is busy with other things
QUIET_FLAGS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync"
)


@pytest.fixture(scope="session")
def browser_type_launch_args(browser_type_launch_args: dict[str, Any]) -> dict[str, Any]:
    chromium = shutil.which("chromium")
    assert chromium, "the browser tests need Chromium: apt-get install chromium"
    return {**browser_type_launch_args, "executable_path": chromium, "args": QUIET_FLAGS.split()}


@pytest.fixture(scope="session")
def base_url() -> None:
    """None: pages are opened by their whole address. (The plugin's own warns under pytest 9.)"""


@pytest.fixture(autouse=True, scope="session")
def charts() -> None:
    """Have uPlot in place, as after an installation, in a checkout that was not installed too."""
    hatch_build.bring_in(Path(__file__).parents[2] / hatch_build.VENDOR)


@pytest.fixture
def live(tmp_path: Path) -> Iterator[LiveService]:
    service = LiveService(tmp_path)
    yield service
    service.close()


@pytest.fixture
def complaints(page: Page, live: LiveService) -> list[str]:
    """What the browser complained of, and what it asked of other origins."""
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text) if is_bad(message.type) else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda each: None if is_ours(each.url, live.url) else said.append(each.url))
    return said


@pytest.fixture
def signed_in(page: Page, live: LiveService, complaints: list[str]) -> Iterator[Page]:
    """A page on the list of sweeps. At the end it must have had nothing to complain of."""
    page.set_default_timeout(PATIENCE_MILLISECONDS)
    expect.set_options(timeout=PATIENCE_MILLISECONDS)
    page.goto(live.signin_link)
    yield page
    assert complaints == []


def is_bad(kind: str) -> bool:
    return kind in {"error", "warning"}


def is_ours(url: str, origin: str) -> bool:
    return url.startswith((f"{origin}/", "blob:", "data:"))
