"""Every measurement of a sweep, in one request."""

import csv
import io
import math
from collections.abc import Callable
from typing import Any

import pytest
from starlette.testclient import TestClient

from service.api.routes.results import measurements
from service.store.store import Store
from tests.service.conftest import changed
from tests.service.training import measured, rising, train
from workers.messages.progress import Progress


def test_every_measurement_of_every_run_is_a_line_of_one_answer(
    client: TestClient, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measurements, "RUNS_AT_ONCE", 5)
    other = client.post("/api/v1/sweeps", json=changed()).json()["id"]
    link = client.post("/api/v1/sweeps", json=changed(name="two")).json()["links"]["self"]
    train(store, 5, rising)
    reads: list[object] = []
    read = store.read

    def counted(query: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        reads.append(query)
        return read(query, *args, **kwargs)

    monkeypatch.setattr(store, "read", counted)
    answer = client.get(f"{link}/measurements")
    assert answer.headers["content-type"].startswith("text/csv")
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert len(rows) == 12 * 5
    assert len(reads) < 8
    assert not any(row["run"].startswith(other) for row in rows)
    for run in client.get(f"{link}/runs").json()["items"]:
        own = [row for row in rows if row["run"] == run["id"]]
        alone = client.get(f"{run['links']['self']}/measurements?format=csv").text
        assert {(row["label"], row["seed"]) for row in own} == {(run["label"], str(run["seed"]))}
        for row, expected in zip(own, csv.DictReader(io.StringIO(alone)), strict=True):
            assert {name: row[name] for name in expected} == expected


def test_what_is_not_finite_is_written_as_it_is(client: TestClient, store: Store) -> None:
    sweep = changed(algorithms=[{"name": "ddpg"}], environments=["Pendulum"], seeds=1)
    link = client.post("/api/v1/sweeps", json=sweep).json()["links"]["self"]
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    points = (measured(claim.specs[0], 800, math.nan), measured(claim.specs[0], 1600, math.inf))
    store.record(claim, Progress(1600, measurements=points))
    rows = list(csv.DictReader(io.StringIO(client.get(f"{link}/measurements").text)))
    assert [row["return_mean"] for row in rows] == ["NaN", "Infinity"]


def test_a_sweep_without_measurements_has_a_heading(client: TestClient) -> None:
    link = client.post("/api/v1/sweeps", json=changed()).json()["links"]["self"]
    [heading] = client.get(f"{link}/measurements").text.splitlines()
    assert heading.startswith("run,label,algorithm,environment,w1,w2,config,seed,timestep,")


def test_parquet_has_the_rows_of_the_csv_with_types(
    client: TestClient, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra `parquet` is not installed")
    monkeypatch.setattr(measurements, "RUNS_AT_ONCE", 5)
    entries = [{"name": "ddpg", "label": "=1+1"}, {"name": "ddpg", "config": {"noise": 0.5}}]
    posted = client.post("/api/v1/sweeps", json=changed(algorithms=entries)).json()
    link = f"{posted['links']['self']}/measurements"
    train(store, 5, rising)
    answer = client.get(link, params={"format": "parquet"})
    assert answer.headers["content-type"] == "application/vnd.apache.parquet"
    accepted = client.get(link, headers={"Accept": "application/vnd.apache.parquet"})
    assert accepted.content == answer.content
    file = parquet.ParquetFile(io.BytesIO(answer.content))
    assert file.num_row_groups == 3
    rows = file.read().to_pylist()
    texts = list(csv.DictReader(io.StringIO(client.get(link).text)))
    assert len(rows) == len(texts) == 60
    assert list(rows[0]) == list(texts[0])
    assert rows[0]["label"] == "=1+1"
    for row, text in zip(rows, texts, strict=True):
        assert (row["run"], row["config"]) == (text["run"], text["config"])
        assert isinstance(row["timestep"], int)
        for name in ("seed", "timestep", "return_mean", "seconds", "critic_loss"):
            assert row[name] == float(text[name])


def test_parquet_of_a_sweep_without_measurements_is_an_empty_table(client: TestClient) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra `parquet` is not installed")
    link = client.post("/api/v1/sweeps", json=changed()).json()["links"]["self"]
    answer = client.get(f"{link}/measurements", params={"format": "parquet"})
    table = parquet.read_table(io.BytesIO(answer.content))
    assert table.num_rows == 0
    assert "return_mean" in table.column_names
