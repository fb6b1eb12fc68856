"""The pages: for signed-in browsers, with nothing inline and nothing from elsewhere."""

from html.parser import HTMLParser
from pathlib import Path

import pytest
from starlette.testclient import TestClient

import hatch_build
from service.api.routes import pages
from service.api.routes.pages import modules, static_version

ROOT = Path(__file__).parents[4]
PAGES = ("/", "/sweeps/3f9a0c51b7de")


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
    answer = stranger.get(f"/static/{static_version()}/sweep.js")
    assert answer.status_code == 200
    assert "immutable" in answer.headers["cache-control"]


def test_browsers_that_ask_for_an_icon_by_themselves_find_it(client: TestClient) -> None:
    found = client.get(client.get("/favicon.ico").headers["location"])
    assert found.headers["content-type"] == "image/svg+xml"


def test_another_version_s_address_is_not_kept(stranger: TestClient) -> None:
    assert stranger.get("/static/000000000000/sweep.js").headers["cache-control"] == "no-cache"


def test_the_version_changes_with_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "STATIC", tmp_path)
    versions = {static_version()}
    for text in ("a", "ab"):
        (tmp_path / "page.css").write_text(text)
        versions.add(static_version())
    assert len(versions) == 3


def test_every_imported_module_is_named_once(client: TestClient) -> None:
    loaded = [path.rpartition("/")[2] for path in References(client.get("/").text).loaded]
    scripts = [name for name in loaded if name.endswith(".js")]
    assert sorted(set(scripts)) == sorted({*modules("sweeps.js", ""), "theme.js"})
    assert {"sweeps.js", "format.js", "events.js"} <= set(scripts)
    assert "chart.js" not in scripts


def test_nothing_outside_the_static_folder_is_served(stranger: TestClient) -> None:
    for path in ("%2e%2e/templates/base.html", "..%2f__init__.py", "%2e%2e%2f__init__.py", ""):
        assert stranger.get(f"/static/0/{path}").status_code == 404


def test_an_id_is_text(client: TestClient) -> None:
    assert "<script>alert" not in client.get("/sweeps/<script>alert(1)<%2Fscript>").text


def test_the_charts_licence_is_served_beside_them(stranger: TestClient) -> None:
    assert "Leon Sorokin" in stranger.get("/static/0/vendor/uplot.LICENSE.txt").text
