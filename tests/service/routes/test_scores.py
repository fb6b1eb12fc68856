"""Table 1 over REST, in every form, from stored measurements."""

import csv
import io
import json
import math
import statistics
from typing import Any

import pytest
from starlette.testclient import TestClient

from service.schemas.score_table_answer import inert
from service.store.store import Store
from tests.service.conftest import SWEEP, changed
from tests.service.training import RANDOM, random_return, rising, train
from workers.run_spec import RunSpec


def finals(algorithm: str) -> list[float]:
    """The last return_history of each seed: half its return_mean (see `measured`)."""
    return [rising(RunSpec(algorithm, "", seed), 4000) / 2 for seed in range(3)]


def test_mean_deviation_and_interval_of_each_cell(reader: TestClient, trained: str) -> None:
    answer = reader.get(f"{trained}/table?normalized=false").json()
    assert answer["environments"] == ["MassPoint", "Pendulum"]
    assert [row["label"] for row in answer["rows"]] == ["ddpg", "hybrid-ddpg"]
    for row in answer["rows"]:
        for entry in row["entries"]:
            scores = finals(entry["algorithm"])
            half = 4.302652730 * statistics.stdev(scores) / math.sqrt(3)
            assert (entry["runs"], entry["ended"], entry["n"]) == (3, 3, 3)
            assert entry["mean"] == pytest.approx(statistics.mean(scores))
            assert entry["std"] == pytest.approx(statistics.stdev(scores))
            assert entry["high"] - entry["low"] == pytest.approx(2 * half)
            assert entry["is_best"] is (entry["algorithm"] == "hybrid-ddpg")


def test_normalised_unless_asked_otherwise(reader: TestClient, trained: str) -> None:
    answer = reader.get(f"{trained}/table").json()
    assert answer["normalized"] is True
    entry = answer["rows"][0]["entries"][1]
    expected = [(score - RANDOM) / (0.0 - RANDOM) for score in finals("ddpg")]
    assert entry["mean"] == pytest.approx(statistics.mean(expected))


@pytest.mark.parametrize(
    ("form", "media_type", "holds"),
    [
        ("json", "application/json", '"label":"ddpg"'),
        ("csv", "text/csv", "environment,label,algorithm,w1,w2,config"),
        ("markdown", "text/markdown", r"**=50% \| of"),
        ("latex", "application/x-latex", r"\caption{=50\% \textbar{} of"),
    ],
)
def test_forms(reader: TestClient, trained: str, form: str, media_type: str, holds: str) -> None:
    named = reader.get(f"{trained}/table?format={form}")
    accepted = reader.get(f"{trained}/table", headers={"Accept": media_type})
    assert named.status_code == accepted.status_code == 200
    assert named.headers["content-type"].startswith(media_type)
    assert named.content == accepted.content
    assert holds in named.text


def test_csv_has_a_line_per_entry(reader: TestClient, trained: str) -> None:
    text = reader.get(f"{trained}/table?format=csv&normalized=false").text
    rows = list(csv.DictReader(io.StringIO(text)))
    assert [(row["environment"], row["label"]) for row in rows] == [
        ("MassPoint", "ddpg"),
        ("MassPoint", "hybrid-ddpg"),
        ("Pendulum", "ddpg"),
        ("Pendulum", "hybrid-ddpg"),
    ]
    assert float(rows[0]["mean"]) == statistics.mean(finals("ddpg"))
    assert rows[1]["is_best"] == "True"


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@sum(a1)", "\t=1", "\r=1"])
def test_no_cell_of_text_is_a_formula(text: str) -> None:
    assert inert(text) == f"'{text}"
    assert inert(f"a{text}") == f"a{text}"


def test_nothing_finished_nothing_finite(client: TestClient, store: Store) -> None:
    link = client.post("/api/v1/sweeps", json=SWEEP).json()["links"]["table"]
    empty: Any = json.loads(client.get(link).text, parse_constant=pytest.fail)
    entries = [entry for row in empty["rows"] for entry in row["entries"]]
    assert [(entry["n"], entry["mean"], entry["is_best"]) for entry in entries] == [
        (0, None, False)
    ] * 4
    assert "12 of 12 runs have not ended" in empty["definition"]
    train(store, 2, lambda spec, _: math.nan if spec.seed else 1.0)
    one_left = client.get(f"{link}?normalized=false").json()
    for row in one_left["rows"]:
        for entry in row["entries"]:
            assert (entry["n"], entry["runs"], entry["mean"]) == (1, 3, 0.5)
            assert entry["std"] is entry["low"] is entry["high"] is None
    for form in ("csv", "markdown", "latex"):
        assert "nan" not in client.get(f"{link}?format={form}").text.lower()


@pytest.mark.parametrize(
    ("query", "field", "says"),
    [
        ("metric=critic_loss", "metric", "return_history"),
        ("format=xlsx", "format", "latex"),
        ("normalized=perhaps", "normalized", "boolean"),
        ("band=std", "band", "not permitted"),
    ],
)
def test_a_wrong_question_is_refused(
    reader: TestClient, trained: str, query: str, field: str, says: str
) -> None:
    response = reader.get(f"{trained}/table?{query}")
    assert response.status_code == 422
    (error,) = response.json()["errors"]
    assert error["field"] == field
    assert says in error["message"]


def test_of_no_sweep(client: TestClient) -> None:
    assert client.get("/api/v1/sweeps/0123456789ab/table").status_code == 404


def test_statistics(reader: TestClient, trained: str) -> None:
    answer = json.loads(reader.get(f"{trained}/statistics").text, parse_constant=pytest.fail)
    assert answer["tasks"] == ["MassPoint", "Pendulum"]
    assert answer["lacking"] == answer["unscored"] == []
    for label, iqm in zip(
        ("ddpg", "hybrid-ddpg"), answer["interquartile_mean"]["values"], strict=True
    ):
        assert (iqm["label"], iqm["n"]) == (label, 6)
        assert iqm["low"] <= iqm["value"] <= iqm["high"]
    (pair,) = answer["probability_of_improvement"]["pairs"]
    assert (pair["x"], pair["y"]) == ("ddpg", "hybrid-ddpg")
    assert pair["same_seeds"] == {"value": 0.0, "low": 0.0, "high": 0.0}
    profiles = answer["performance_profiles"]
    assert all(len(each["share"]) == len(profiles["thresholds"]) for each in profiles["profiles"])
    differences = answer["paired_differences"]["values"]
    assert [(each["environment"], each["n"], each["wins"]) for each in differences] == [
        ("MassPoint", 3, 3),
        ("Pendulum", 3, 3),
    ]
    unit = 0.0 - RANDOM
    assert differences[1]["mean"] == pytest.approx(50 * (len("hybrid-ddpg") - len("ddpg")) / unit)
    assert all(
        "95 %" in answer[part]["definition"]
        for part in (
            "interquartile_mean",
            "probability_of_improvement",
            "performance_profiles",
            "paired_differences",
        )
    )


def test_the_same_data_give_the_same_statistics(reader: TestClient, trained: str) -> None:
    first = reader.get(f"{trained}/statistics").content
    assert reader.get(f"{trained}/statistics").content == first


def test_statistics_of_nothing_and_of_one_seed(client: TestClient, store: Store) -> None:
    link = client.post("/api/v1/sweeps", json=changed(seeds=1)).json()["links"]["statistics"]
    empty = client.get(link).json()
    assert (empty["tasks"], empty["unscored"]) == ([], ["ddpg", "hybrid-ddpg"])
    for environment in ("MassPoint", "Pendulum"):
        store.record_random_return(random_return(environment, RANDOM))
    train(store, 2, rising)
    answer = json.loads(client.get(link).text, parse_constant=pytest.fail)
    iqm = answer["interquartile_mean"]["values"][0]
    assert iqm["n"] == 2
    assert iqm["low"] is iqm["high"] is None
    difference = answer["paired_differences"]["values"][0]
    assert (difference["n"], difference["low"]) == (1, None)


def test_statistics_of_too_much_are_refused(client: TestClient) -> None:
    link = client.post("/api/v1/sweeps", json=changed(seeds=900)).json()["links"]["statistics"]
    response = client.get(link)
    assert response.status_code == 422
    (error,) = response.json()["errors"]
    assert (error["field"], error["limit"]) == ("sweep", 4_000_000)
