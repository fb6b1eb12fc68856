"""Several sweeps as one: curves, tables, statistics and figures."""

import csv
import io
from typing import Any

import pytest
from starlette.testclient import TestClient

from service.store.store import Store
from tests.service.conftest import changed
from tests.service.training import RANDOM, measured, random_return, rising, train
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec

API = "/api/v1/sweeps"


@pytest.fixture
def two(client: TestClient, store: Store) -> tuple[str, str]:
    """A sweep of ddpg, and one of ddpg and its hybrid with other seeds; in Pendulum."""
    store.record_random_return(random_return("Pendulum", RANDOM))
    one = {"environments": ["Pendulum"], "algorithms": [{"name": "ddpg"}], "name": "old"}
    first = client.post(API, json=changed(**one, seeds=[0, 1, 2])).json()["id"]
    train(store, 5, rising)
    both = [{"name": "ddpg"}, {"name": "hybrid-ddpg"}]
    asked = changed(environments=["Pendulum"], algorithms=both, name="new", seeds=[1, 2, 3])
    second = client.post(API, json=asked).json()["id"]
    train(store, 5, lambda spec, step: rising(spec, step) + step / 10)
    return first, second


def test_entries_say_whose_they_are_and_keep_their_runs(
    client: TestClient, two: tuple[str, str]
) -> None:
    together = client.get(f"{API}/{two[0]}+{two[1]}/curves", params={"seeds": True}).json()
    assert together["sweep"] == "+".join(two)
    [panel] = together["panels"]
    curves = {curve["label"]: curve for curve in panel["curves"]}
    assert list(curves) == ["ddpg · old", "ddpg · new", "hybrid-ddpg · new"]
    for sweep, name in zip(two, ("old", "new"), strict=True):
        alone = client.get(f"{API}/{sweep}/curves", params={"seeds": True}).json()
        for curve in alone["panels"][0]["curves"]:
            assert curves[f"{curve['label']} · {name}"] == {
                **curve, "label": f"{curve['label']} · {name}"
            }  # fmt: skip
    assert client.get(f"{API}/{two[0]}+{two[1]}/metrics").json()[-1] == "critic_loss"


def test_the_table_has_one_best_of_all(client: TestClient, two: tuple[str, str]) -> None:
    table = client.get(f"{API}/{'+'.join(two)}/table").json()
    best = {row["label"]: row["entries"][0]["is_best"] for row in table["rows"]}
    assert best == {"ddpg · old": False, "ddpg · new": False, "hybrid-ddpg · new": True}
    text = client.get(f"{API}/{'+'.join(two)}/table", params={"format": "latex"}).text
    assert "old and new" in text


def test_runs_of_equal_seed_are_pairs_across_sweeps(
    client: TestClient, two: tuple[str, str]
) -> None:
    asked = {"reference": "ddpg · old"}
    answer = client.get(f"{API}/{'+'.join(two)}/statistics", params=asked).json()
    differences = {each["label"]: each for each in answer["paired_differences"]["values"]}
    assert set(differences) == {"ddpg · new", "hybrid-ddpg · new"}
    found = differences["ddpg · new"]
    assert (found["baseline"], found["pairs"], found["n"], found["wins"]) == ("ddpg · old", 2, 2, 2)
    # The curves of equal seeds differ by step / 10 everywhere; the steps' mean is 2400.
    unit = 0 - RANDOM
    assert found["mean"] == pytest.approx(240 / unit)
    assert found["std"] == pytest.approx(0.0, abs=1e-9)
    own = client.get(f"{API}/{'+'.join(two)}/statistics").json()
    baselines = {each["baseline"] for each in own["paired_differences"]["values"]}
    assert baselines == {"ddpg · old", "ddpg · new"}


def test_the_figure_and_its_numbers(client: TestClient, two: tuple[str, str]) -> None:
    link = f"{API}/{'+'.join(two)}"
    rows = list(csv.DictReader(io.StringIO(client.get(f"{link}/plot.csv").text)))
    assert {row["entry"] for row in rows} == {"ddpg · old", "ddpg · new", "hybrid-ddpg · new"}
    assert b"ddpg \xc2\xb7 old" in client.get(f"{link}/plot.svg").content


def test_equal_names_are_told_apart_by_ids(client: TestClient) -> None:
    ids = [client.post(API, json=changed()).json()["id"] for _ in range(2)]
    rows = client.get(f"{API}/{'+'.join(ids)}/table").json()["rows"]
    assert [row["label"] for row in rows][:2] == [
        f"{label} · small ({ids[0]})" for label in ("ddpg", "hybrid-ddpg")
    ]


def test_a_sweep_named_twice_is_one(client: TestClient, two: tuple[str, str]) -> None:
    alone = client.get(f"{API}/{two[0]}+{two[0]}/table").json()
    assert alone == client.get(f"{API}/{two[0]}/table").json()


def test_an_answer_is_kept_until_one_of_the_sweeps_changes(
    client: TestClient, store: Store, two: tuple[str, str]
) -> None:
    link = f"{API}/{'+'.join(two)}/table"
    tag = client.get(link).headers["etag"]
    assert client.get(link, headers={"If-None-Match": tag}).status_code == 304
    client.patch(f"{API}/{two[1]}", json={"name": "newer"})
    assert client.get(link, headers={"If-None-Match": tag}).status_code == 200


@pytest.mark.parametrize(
    ("ids", "status", "said"),
    [
        ("{0}+ffffffffffff", 404, "no sweep 'ffffffffffff'"),
        ("{0}+", 404, "no sweep ''"),
        ("+".join("abcdefghijklmnopqrstu"), 422, "at most 20"),
    ],
)
def test_what_cannot_be_compared_is_refused(
    client: TestClient, two: tuple[str, str], ids: str, status: int, said: str
) -> None:
    answer = client.get(f"{API}/{ids.format(*two)}/curves")
    assert answer.status_code == status
    assert said in answer.json()["detail"]


def test_a_run_is_of_one_sweep(client: TestClient, two: tuple[str, str]) -> None:
    answer = client.get(f"{API}/{'+'.join(two)}/curves", params={"run": 0})
    assert (answer.status_code, answer.json()["errors"][0]["field"]) == (422, "run")


def test_versions_of_a_task_are_not_compared(client: TestClient, store: Store) -> None:
    specs = [RunSpec("ddpg", "Pendulum", seed=0)]
    request: dict[str, Any] = {
        "algorithms": [{"name": "ddpg"}], "environments": ["Pendulum"], "seeds": 1
    }  # fmt: skip
    ids = [
        store.create_sweep(
            "s", 0, request, specs, entries=[0], environment_versions={"Pendulum": version}
        ).id
        for version in (1, 2)
    ]
    claim = store.claim_cohort("worker", 60.0)
    assert claim is not None
    store.record(claim, Progress(800, measurements=(measured(specs[0], 800, 1.0),)))
    answer = client.get(f"{API}/{'+'.join(ids)}/table")
    assert answer.status_code == 409
    assert "Pendulum changed between these sweeps" in answer.json()["detail"]
