"""A report opens from a file, without the service, and is readable in both themes."""

from pathlib import Path

import httpx2
import pytest
from playwright.sync_api import Page, expect

from tests.web.live_service import TOKEN, LiveService
from tests.web.test_accessibility import violations

pytestmark = pytest.mark.browser


def test_it_opens_without_the_service(live: LiveService, page: Page, tmp_path: Path) -> None:
    sweep = live.add_sweep()
    live.train(0, 20_000)
    headers = {"Authorization": f"Bearer {TOKEN}"}
    address = f"{live.url}/api/v1/sweeps/{sweep.id}/report"
    answer = httpx2.get(address, headers=headers, timeout=120.0, trust_env=False)
    file = tmp_path / "report.html"
    file.write_bytes(answer.content)
    live.stop()
    asked: list[str] = []
    said: list[str] = []
    page.on("request", lambda each: asked.append(each.url))
    page.on("console", lambda message: said.append(message.text))
    for theme in ("light", "dark"):
        page.emulate_media(color_scheme=theme)
        page.goto(file.as_uri())
        expect(page.get_by_role("img", name="Learning curves of first look")).to_be_visible()
        expect(page.get_by_role("region", name="Paired differences")).to_contain_text("hybrid-ddpg")
        assert violations(page) == []
        page.screenshot(path=str(tmp_path / f"{theme}.png"), full_page=True)
    page.set_viewport_size({"width": 400, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth") <= 400
    assert [url for url in asked if url != file.as_uri()] == []
    assert said == []
