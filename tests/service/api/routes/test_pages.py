"""The pages: for signed-in browsers, with nothing inline and nothing from elsewhere."""

from html.parser import HTMLParser
from pathlib import Path

import pytest
from starlette.testclient import TestClient

import hatch_build
from service.api.shell import static
from service.api.static_files import StaticFolder

ROOT = Path(__file__).parents[4]
PAGES = (
    "/",
    "/sweeps/3f9a0c51b7de",
    "/sweeps/3f9a0c51b7de/runs",
    "/runs/3f9a0c51b7de-1",
    "/compare",
    "/workers",
    "/catalogue",
)


@pytest.fixture(autouse=True, scope="module")
def charts() -> None:
    """Have uPlot in place, as after an installation, in a checkout that was not installed too."""
    hatch_build.bring_in(ROOT / hatch_build.VENDOR)


class References(HTMLParser):
    """What a page loads, and what it says to run or paint inline."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.inline: list[str] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag in {"script", "img"}:
            self.loaded.append(given.get("src") or "")
        if tag == "link":
            self.loaded.append(given.get("href") or "")
        if tag == "style" or (tag == "script" and "src" not in given):
            self.inline.append(tag)
        self.inline += [name for name in given if name == "style" or name.startswith("on")]


@pytest.mark.parametrize("page", PAGES)
def test_a_page_needs_the_token(stranger: TestClient, page: str) -> None:
    assert stranger.get(page).status_code == 401


@pytest.mark.parametrize("page", PAGES)
def test_a_page_is_all_ours_and_has_nothing_inline(client: TestClient, page: str) -> None:
    answer = client.get(page)
    assert answer.headers["content-type"].startswith("text/html")
    assert "default-src 'self'" in answer.headers["content-security-policy"]
    references = References(answer.text)
    assert references.inline == []
    assert references.loaded
    for path in references.loaded:
        assert path.startswith("/static/")
        assert client.get(path).status_code == 200, path


def test_static_files_need_no_token_and_are_kept_for_good(stranger: TestClient) -> None:
    answer = stranger.get(f"/static/{static().version}/pages/sweep.js")
    assert answer.status_code == 200
    assert "immutable" in answer.headers["cache-control"]


def test_browsers_that_ask_for_an_icon_by_themselves_find_it(client: TestClient) -> None:
    found = client.get(client.get("/favicon.ico").headers["location"])
    assert found.headers["content-type"] == "image/svg+xml"


def test_another_version_s_address_is_not_kept(stranger: TestClient) -> None:
    assert (
        stranger.get("/static/000000000000/pages/sweep.js").headers["cache-control"] == "no-cache"
    )


def test_no_file_is_read_to_know_the_version(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    version = static().version
    monkeypatch.setattr(StaticFolder, "__init__", None)
    for _ in range(2):
        assert client.get(f"/static/{version}/pages/sweep.js").status_code == 200
        assert version in client.get("/").text


def test_every_imported_module_is_named_once(client: TestClient) -> None:
    prefix = f"/static/{static().version}/"
    loaded = [path.removeprefix(prefix) for path in References(client.get("/").text).loaded]
    scripts = [name for name in loaded if name.endswith(".js")]
    modules = static().modules("pages/sweeps.js")
    assert sorted(set(scripts)) == sorted({*modules, "parts/theme.js"})
    assert {"pages/sweeps.js", "texts/format.js", "connection/events.js"} <= set(scripts)
    assert "charts/chart.js" not in scripts


def test_nothing_outside_the_static_folder_is_served(stranger: TestClient) -> None:
    for path in ("%2e%2e/templates/base.html", "..%2f__init__.py", "%2e%2e%2f__init__.py", ""):
        assert stranger.get(f"/static/0/{path}").status_code == 404


def test_an_id_is_text(client: TestClient) -> None:
    assert "<script>alert" not in client.get("/sweeps/<script>alert(1)<%2Fscript>").text


def test_the_charts_licence_is_served_beside_them(stranger: TestClient) -> None:
    assert "Leon Sorokin" in stranger.get("/static/0/vendor/uplot.LICENSE.txt").text
