"""A report is one file: all of the sweep's answers in it, and nothing from elsewhere."""

import base64
import re
from html.parser import HTMLParser

import pytest
import yaml
from starlette.testclient import TestClient

from service.api.routes.results import report as reports
from service.api.routes.results import scores as statistics
from service.store.store import Store
from tests.service.conftest import SWEEP, changed
from tests.service.training import RANDOM, random_return, rising, train

API = "/api/v1/sweeps"


class Elements(HTMLParser):
    """The elements of a page with their attributes, and its texts."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.seen: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.texts.append(data.strip())


@pytest.fixture
def sweep(client: TestClient, store: Store) -> str:
    for environment in SWEEP["environments"]:
        store.record_random_return(random_return(environment, RANDOM))
    asked = changed(name="<b>bold</b> & co", notes="**why** <i>\n</pre>", tags=["paper"])
    posted: str = client.post(API, json=asked).json()["id"]
    train(store, 5, rising)
    return posted


def test_it_loads_nothing_and_runs_nothing(client: TestClient, sweep: str) -> None:
    answer = client.get(f"{API}/{sweep}/report")
    assert answer.headers["content-type"].startswith("text/html")
    assert "default-src 'none'" in answer.headers["content-security-policy"]
    elements = Elements(answer.text).seen
    tags = {tag for tag, _ in elements}
    assert tags & {"script", "link", "img", "iframe", "object", "b", "i"} == {"b"}
    assert "svg" in tags
    for tag, attributes in elements:
        assert not any(name.startswith("on") for name in attributes), (tag, attributes)
        for name in ("src", "href", "xlink:href"):
            assert (attributes.get(name) or "#").startswith(("#", "data:")), (tag, attributes)
    assert "url(http" not in answer.text
    assert "@import" not in answer.text


def test_it_says_what_the_service_says(client: TestClient, sweep: str) -> None:
    page = Elements(client.get(f"{API}/{sweep}/report").text)
    texts = page.texts
    assert "<b>bold</b> & co" in texts
    assert "**why** <i>\n</pre>" in texts
    table = client.get(f"{API}/{sweep}/table").json()
    for row in table["rows"]:
        for entry in row["entries"]:
            star = " *" if entry["is_best"] else ""
            assert f"{entry['mean']:.3f} ± {entry['std']:.3f} ({entry['n']}){star}" in texts
    answer = client.get(f"{API}/{sweep}/statistics").json()
    for each in answer["paired_differences"]["values"]:
        assert f"{each['low']:.3f} to {each['high']:.3f}" in texts
        assert f"{each['wins']} of {each['n']}" in texts
    [data] = [a["href"] for tag, a in page.seen if tag == "a"]
    numbers = base64.b64decode(str(data).partition("base64,")[2]).decode()
    assert numbers.count("\n") == 1 + 4 * 5
    [request] = [text for text in texts if text.startswith("name: ")]
    repeated = yaml.safe_load(request)
    assert client.post(API, params={"dry_run": True}, json=repeated).json()["runs"]["total"] == 12


def test_several_sweeps_make_one_report(client: TestClient, sweep: str) -> None:
    other = client.post(API, json=changed(name="other")).json()["id"]
    texts = Elements(client.get(f"{API}/{sweep}+{other}/report").text).texts
    assert "<b>bold</b> & co and other" in texts
    assert {"ddpg · other", "ddpg · <b>bold</b> & co"} <= set(texts)
    assert len([text for text in texts if text.startswith("name: ")]) == 2


def test_what_is_too_much_to_show_is_told(
    client: TestClient, sweep: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reports, "MAX_CURVES", 3)
    monkeypatch.setattr(statistics, "MAX_COMPARED", 1)
    page = client.get(f"{API}/{sweep}/report").text
    assert "<svg" not in page
    assert "There is no figure: the sweep has 4 curves; this figure shows at most 3." in page
    assert "There are no statistics: " in page


def test_a_sweep_that_waits_has_a_report(client: TestClient) -> None:
    link = f"{API}/{client.post(API, json=SWEEP).json()['id']}/report"
    page = client.get(link).text
    assert "No task has a score of every entry yet." in page
    assert re.search(r"12 runs, 12 queued", page)
