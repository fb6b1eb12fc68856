"""The documentation site builds without a warning, and shows nothing that is not there."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import algorithms
import physics
from service.client import Client
from tests.docs.pages import PAGES, ROOT, name_of


class Page(HTMLParser):
    """What a page refers to, and what can be referred to in it."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.feed(file.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = {name: value for name, value in attrs if value}
        self.anchors |= {named[name] for name in ("id", "name") if name in named}
        url = named.get("href") or named.get("src")
        if url:
            (self.links if tag == "a" else self.loaded).append(url)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    built = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
    )
    assert built.returncode == 0, built.stderr
    return folder


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    return {file: Page(file) for file in site.rglob("*.html")}


def target(site: Path, file: Path, path: str) -> Path:
    """The file that a relative URL in a page, or one from the site's root, leads to."""
    if not path:
        return file
    return (site / path[1:] if path.startswith("/") else file.parent / path).resolve()


def test_no_link_and_no_anchor_is_dead(site: Path, pages: dict[Path, Page]) -> None:
    dead = []
    for file, page in pages.items():
        for url in page.links + page.loaded:
            parts = urlsplit(url)
            if parts.scheme or parts.netloc:
                continue
            leads_to = target(site, file, unquote(parts.path))
            is_dead = not leads_to.exists() or (
                parts.fragment
                and leads_to in pages
                and unquote(parts.fragment) not in pages[leads_to].anchors
            )
            if is_dead:
                dead.append(f"{file.relative_to(site)}: {url}")
    assert not dead
    assert sum(len(page.links) for page in pages.values()) > 1000


def test_nothing_is_loaded_from_another_host(site: Path, pages: dict[Path, Page]) -> None:
    loaded = [url for page in pages.values() for url in page.loaded]
    assert loaded
    assert [url for url in loaded if urlsplit(url).netloc] == []
    sheets = [file.read_text() for file in site.rglob("*.css")]
    assert sheets
    assert not any(re.search(r"url\(\W*(https?:)?//|@import", sheet) for sheet in sheets)


def test_every_page_of_the_repository_is_on_the_site(site: Path, pages: dict[Path, Page]) -> None:
    for page in PAGES:
        name = re.sub(r"README\.md$", "index.md", name_of(page))
        assert (site / name).with_suffix(".html") in pages


def test_the_reference_has_every_public_name(site: Path, pages: dict[Path, Page]) -> None:
    reference = site / "docs" / "reference"
    for package in (physics, algorithms):
        anchors = pages[reference / f"{package.__name__}.html"].anchors
        assert {f"{package.__name__}.{name}" for name in package.__all__} <= anchors
    methods = {name for name in vars(Client) if not name.startswith("_")}
    anchors = pages[reference / "client.html"].anchors
    assert {f"service.client.Client.{name}" for name in methods} <= anchors
