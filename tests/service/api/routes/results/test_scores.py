"""The score table and the statistics over REST, in every form, from stored measurements."""

import csv
import io
import json
import math
import statistics
from collections.abc import Callable
from typing import Any

import pytest
from scipy import stats
from starlette.testclient import TestClient

from algorithms.early_end import Divergence
from service.api.schemas.score_table_answer import inert
from service.store.store import Store
from tests.service.conftest import SWEEP, changed
from tests.service.training import RANDOM, measured, random_return, rising, train
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec


def finals(algorithm: str) -> list[float]:
    """What each seed earns in the last tenth of 4,000 timesteps: at its end."""
    return [rising(RunSpec(algorithm, "", seed), 4000) for seed in range(3)]


def test_mean_deviation_and_interval_of_each_cell(reader: TestClient, trained: str) -> None:
    answer = reader.get(f"{trained}/table?normalized=false").json()
    assert answer["environments"] == ["MassPoint", "Pendulum"]
    assert [row["label"] for row in answer["rows"]] == ["ddpg", "hybrid-ddpg"]
    for row in answer["rows"]:
        for entry in row["entries"]:
            scores = finals(entry["algorithm"])
            half = 4.302652730 * statistics.stdev(scores) / math.sqrt(3)
            assert (entry["runs"], entry["n"], entry["unfinished"]) == (3, 3, {})
            assert entry["mean"] == pytest.approx(statistics.mean(scores))
            assert entry["std"] == pytest.approx(statistics.stdev(scores))
            assert entry["high"] - entry["low"] == pytest.approx(2 * half)
            assert entry["is_best"] is (entry["algorithm"] == "hybrid-ddpg")


@pytest.mark.parametrize(
    ("score", "of", "said"),
    [
        ("final", lambda seed: rising(RunSpec("ddpg", "", seed), 4000), "the last tenth"),
        (
            "return_history",
            lambda seed: rising(RunSpec("ddpg", "", seed), 4000) / 2,
            "mean of the latest 100 return_mean",
        ),
        ("area", lambda seed: rising(RunSpec("ddpg", "", seed), 2400), "trapezoids"),
    ],
)
def test_the_score_that_is_asked_for(
    reader: TestClient, trained: str, score: str, of: Callable[[int], float], said: str
) -> None:
    """The curves rise evenly, so that their area is what they have reached at half their way."""
    answer = reader.get(f"{trained}/table?normalized=false&score={score}").json()
    assert answer["score"] == score
    assert said in answer["definition"]
    expected = statistics.mean(of(seed) for seed in range(3))
    assert answer["rows"][0]["entries"][0]["mean"] == pytest.approx(expected)
    for form in ("markdown", "latex"):
        text = reader.get(f"{trained}/table?score={score}&format={form}").text
        assert said in text.replace("\\_", "_").replace("\\", "")
    compared = reader.get(f"{trained}/statistics?score={score}").json()
    assert compared["score"] == score
    assert said in compared["definition"]


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
    assert "12 of 12 runs do not count (12 queued)" in empty["definition"]
    train(store, 2, lambda spec, _: math.nan if spec.seed else 1.0)
    one_left = client.get(f"{link}?normalized=false").json()
    for row in one_left["rows"]:
        for entry in row["entries"]:
            assert (entry["n"], entry["runs"], entry["mean"]) == (1, 3, 1.0)
            assert entry["is_best"] is False
            assert entry["std"] is entry["low"] is entry["high"] is None
    for form in ("csv", "markdown", "latex"):
        assert "nan" not in client.get(f"{link}?format={form}").text.lower()


@pytest.mark.parametrize(
    ("query", "field", "says"),
    [
        ("score=critic_loss", "score", "return_history"),
        ("metric=return_mean", "metric", "is not known"),
        ("format=xlsx", "format", "latex"),
        ("normalized=perhaps", "normalized", "boolean"),
        ("band=std", "band", "is not known"),
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
    wilson = stats.binomtest(0, 6).proportion_ci(method="wilson")  # three pairs a task
    assert pair["same_seeds"] == pytest.approx({"value": 0.0, "low": 0.0, "high": wilson.high})
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


def test_runs_that_failed_do_not_count(client: TestClient, store: Store) -> None:
    """A sweep of six runs that all failed has nothing to show, and says so."""
    body = changed(algorithms=[{"name": "sac"}])
    links = client.post("/api/v1/sweeps", json=body).json()["links"]
    for environment in ("MassPoint", "Pendulum"):
        store.record_random_return(random_return(environment, RANDOM))
    while (claim := store.claim_cohort("worker", 60.0)) is not None:
        measurements = tuple(measured(spec, 800, rising(spec, 800)) for spec in claim.specs)
        store.record(claim, Progress(800, measurements=measurements))
        store.fail(claim, "ValueError: action [nan]")
    table = client.get(links["table"]).json()
    (row,) = table["rows"]
    for entry in row["entries"]:
        assert (entry["n"], entry["runs"], entry["mean"]) == (0, 3, None)
        assert (entry["unfinished"], entry["is_best"]) == ({"failed": 3}, False)
    assert "6 of 6 runs do not count (6 failed)" in table["definition"]
    for form in ("markdown", "latex"):
        text = client.get(f"{links['table']}?format={form}").text
        assert "(0 of 3)" in text
        assert "textbf" not in text
        assert "mathbf" not in text
    answer = client.get(links["statistics"]).json()
    assert (answer["tasks"], answer["unscored"]) == ([], ["sac"])
    sweep = client.get(links["self"]).json()
    assert (sweep["status"], sweep["progress"]) == ("finished", 0.2)
    curves = client.get(links["curves"]).json()
    assert "(6 failed) count as far as they were measured" in curves["definition"]
    assert [panel["curves"][0]["unfinished"] for panel in curves["panels"]] == [{"failed": 3}] * 2


def test_a_seed_that_diverged_is_missed_and_said(client: TestClient, store: Store) -> None:
    """The two seeds that are left are far ahead, and win nothing."""
    links = client.post("/api/v1/sweeps", json=changed(environments=["Pendulum"])).json()["links"]
    store.record_random_return(random_return("Pendulum", RANDOM))
    while (claim := store.claim_cohort("worker", 60.0)) is not None:
        measurements = tuple(measured(spec, 4000, rising(spec, 4000)) for spec in claim.specs)
        is_hybrid = claim.specs[0].algorithm == "hybrid-ddpg"
        diverged = (Divergence(2, 4000, 2000, "critic_loss"),) if is_hybrid else ()
        finished = (0, 1) if is_hybrid else (0, 1, 2)
        said = Progress(4000, measurements=measurements, diverged=diverged, finished=finished)
        store.record(claim, said)
    ddpg, hybrid = (row["entries"][0] for row in client.get(links["table"]).json()["rows"])
    assert (hybrid["n"], hybrid["runs"], hybrid["unfinished"]) == (2, 3, {"diverged": 1})
    assert (ddpg["is_best"], hybrid["is_best"]) == (True, False)
    assert "(2 of 3)" in client.get(f"{links['table']}?format=markdown").text
    answer = client.get(links["statistics"]).json()
    assert answer["incomplete"] == [
        {
            "environment": "Pendulum",
            "label": "hybrid-ddpg",
            "n": 2,
            "runs": 3,
            "unfinished": {"diverged": 1},
        }
    ]
    (difference,) = answer["paired_differences"]["values"]
    assert (difference["pairs"], difference["n"]) == (3, 2)


def test_an_entry_whose_presets_differ_by_task_is_one(client: TestClient, store: Store) -> None:
    """TD3's noise is 0.1 on MassPoint and 0.6 on Pendulum; both tasks are common."""
    entries = [{"name": "td3"}, {"name": "td3", "config": {"noise": 0.2}}]
    links = client.post("/api/v1/sweeps", json=changed(algorithms=entries)).json()["links"]
    for environment in ("MassPoint", "Pendulum"):
        store.record_random_return(random_return(environment, RANDOM))
    train(store, 5, rising)
    labels = ["td3", "td3 noise=0.2"]
    table = client.get(links["table"]).json()
    assert [row["label"] for row in table["rows"]] == labels
    assert [[each["n"] for each in row["entries"]] for row in table["rows"]] == [[3, 3]] * 2
    answer = client.get(links["statistics"]).json()
    assert answer["tasks"] == ["MassPoint", "Pendulum"]
    assert answer["lacking"] == answer["incomplete"] == []
    assert [each["label"] for each in answer["interquartile_mean"]["values"]] == labels
    panels = client.get(links["curves"]).json()["panels"]
    assert [[each["label"] for each in panel["curves"]] for panel in panels] == [labels] * 2
    runs = client.get(links["runs"]).json()["items"]
    assert [run["label"] for run in runs] == [label for label in labels * 2 for _ in range(3)]
    assert client.get(runs[4]["links"]["self"]).json()["label"] == "td3 noise=0.2"
    sweep = client.get(links["self"]).json()
    assert [entry["label"] for entry in sweep["entries"]] == labels


def test_statistics_of_too_much_are_refused(client: TestClient) -> None:
    link = client.post("/api/v1/sweeps", json=changed(seeds=900)).json()["links"]["statistics"]
    response = client.get(link)
    assert response.status_code == 422
    (error,) = response.json()["errors"]
    assert (error["field"], error["limit"]) == ("sweep", 4_000_000)


def test_differences_are_from_the_reference_that_is_asked_for(
    reader: TestClient, trained: str
) -> None:
    labels = [one["label"] for one in reader.get(trained).json()["entries"]]
    for reference in labels:
        answer = reader.get(f"{trained}/statistics", params={"reference": reference}).json()
        values = answer["paired_differences"]["values"]
        assert {each["baseline"] for each in values} == {reference}
        assert {each["label"] for each in values} == {*labels} - {reference}
    refusal = reader.get(f"{trained}/statistics", params={"reference": "nobody"})
    assert refusal.status_code == 422
    assert refusal.json()["errors"][0]["field"] == "reference"
