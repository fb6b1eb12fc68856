"""ETags: 304 while nothing of the sweep changed, a new answer as soon as something did."""

from collections import Counter
from typing import Any

import pytest
from starlette.testclient import TestClient

from service.api.revalidation import known_tags
from service.model.caller import Caller
from service.store.store import Store
from tests.service.conftest import changed
from tests.service.training import random_return, train

BODY = changed(environments=["Pendulum"])
PARTS = ("curves", "metrics", "table", "statistics", "plot.svg?max_points=2")


def submitted(client: TestClient) -> str:
    return str(client.post("/api/v1/sweeps", json=BODY).json()["links"]["self"])


@pytest.mark.parametrize("part", PARTS)
def test_what_did_not_change_is_not_sent_again(client: TestClient, store: Store, part: str) -> None:
    url = f"{submitted(client)}/{part}"
    train(store, 2, lambda *_: -500.0)
    first = client.get(url)
    assert first.headers["etag"].startswith('W/"')
    assert first.headers["cache-control"] == "private, no-cache"
    again = client.get(url, headers={"If-None-Match": f'"other", {first.headers["etag"]}'})
    assert (again.status_code, again.content) == (304, b"")
    assert again.headers["etag"] == first.headers["etag"]


def test_who_may_read_and_how_large_a_sweep_is_are_asked_once(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    link = submitted(client)
    tag = client.get(f"{link}/curves").headers["etag"]
    asked: Counter[str] = Counter()

    def count(kind: type, name: str) -> None:
        method = getattr(kind, name)

        def counted(*given: Any) -> Any:
            asked[name] += 1
            return method(*given)

        monkeypatch.setattr(kind, name, counted)

    count(Caller, "sees")
    count(Store, "sweep_version")
    count(Store, "find_sweep")
    assert client.get(f"{link}/curves").status_code == 200
    assert asked == {"sees": 1, "sweep_version": 1, "find_sweep": 1}
    asked.clear()
    assert client.get(f"{link}/curves", headers={"If-None-Match": tag}).status_code == 304
    assert asked == {"sees": 1, "sweep_version": 1}


def test_every_change_of_the_sweep_is_seen(client: TestClient, store: Store) -> None:
    link = submitted(client)
    tags = [client.get(f"{link}/table").headers["etag"]]

    def changes() -> bool:
        tags.append(client.get(f"{link}/table").headers["etag"])
        return tags[-1] not in tags[:-1]

    assert not changes()
    train(store, 1, lambda *_: -500.0, finish=False)
    assert changes(), "measurements"
    store.record_random_return(random_return("Pendulum", -1200.0))
    assert changes(), "the zero of the scale"
    client.post(f"{link}/cancel")
    assert changes(), "a run's status"


def test_another_sweep_is_no_change(client: TestClient) -> None:
    link = submitted(client)
    tag = client.get(f"{link}/table").headers["etag"]
    submitted(client)
    assert client.get(f"{link}/table").headers["etag"] == tag


def test_another_question_is_another_answer(client: TestClient) -> None:
    link = submitted(client)
    asked = [
        client.get(f"{link}/table"),
        client.get(f"{link}/table?normalized=false"),
        client.get(f"{link}/table", headers={"Accept": "text/csv"}),
        client.get(f"{link}/statistics"),
    ]
    assert len({response.headers["etag"] for response in asked}) == 4


def test_refusals_are_not_kept(client: TestClient) -> None:
    refused = client.get(f"{submitted(client)}/table?metric=nothing")
    assert refused.status_code == 422
    assert "etag" not in refused.headers
    missing = client.get("/api/v1/sweeps/none/table", headers={"If-None-Match": 'W/"x"'})
    assert missing.status_code == 404


def test_known_tags() -> None:
    assert known_tags('"a", W/"b"') == {'W/"a"', 'W/"b"'}


@pytest.mark.parametrize(
    "path", ["/sweeps", "/sweeps/{sweep}", "/sweeps/{sweep}/runs", "/runs/{sweep}-0"]
)
def test_what_stands_is_tagged_by_what_it_says(client: TestClient, path: str) -> None:
    sweep = client.post("/api/v1/sweeps", json=BODY).json()["id"]
    url = f"/api/v1{path.format(sweep=sweep)}"
    first = client.get(url)
    known = {"If-None-Match": first.headers["etag"]}
    again = client.get(url, headers=known)
    assert again.status_code == 304
    assert again.content == b""
    assert again.headers["etag"] == first.headers["etag"]
    client.post(f"/api/v1/sweeps/{sweep}/pause")
    changed = client.get(url, headers=known)
    assert changed.status_code == 200
    assert changed.json() != first.json()


def test_what_is_missing_or_changed_has_no_tag(client: TestClient) -> None:
    sweep = client.post("/api/v1/sweeps", json=BODY).json()["id"]
    edited = client.patch(f"/api/v1/sweeps/{sweep}", json={"name": "another"})
    missing = client.get(f"/api/v1/sweeps/{'0' * 12}")
    assert (edited.status_code, missing.status_code) == (200, 404)
    assert "etag" not in edited.headers
    assert "etag" not in missing.headers
