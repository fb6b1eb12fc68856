"""`d3pg diagnose`: tables, CSV and figures of a run or a sweep, against a real server."""

import csv
from pathlib import Path

import pytest

from service.client import Client, ServiceError
from service.settings import Settings
from service.store.store import Store
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import changed
from tests.service.training import rising, train
from tests.workers.policies.test_rollout import write_policy


@pytest.fixture
def sweep(service: Client, store: Store, settings: Settings) -> str:
    body = changed(seeds=2, environments=["MassPoint"], algorithms=[{"name": "ddpg"}])
    sweep = service.submit(body).id
    train(store, 5, rising)
    write_policy(settings.checkpoint_place, f"{sweep}-0", "MassPoint")
    return sweep


def test_a_run_in_tables(d3pg: Command, sweep: str) -> None:
    said = d3pg("diagnose", f"{sweep}-0").stdout
    assert "ddpg in MassPoint, seeds 0" in said
    assert "Norm of d s(t+H) / d s(t) along episodes" in said
    assert as_json(d3pg("diagnose", f"{sweep}-0", "--json"))["done"] == 1


def test_a_sweep_as_csv_and_as_a_figure(d3pg: Command, sweep: str, tmp_path: Path) -> None:
    """Its second run has no policy, which is said and keeps the first one from nothing."""
    numbers, picture = tmp_path / "found.csv", tmp_path / "growth.svg"
    told = d3pg("diagnose", sweep, "-o", str(numbers))
    assert "has no policy" in told.stdout
    assert "of 2 runs are diagnosed" in told.stderr
    with numbers.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {(row["label"], row["environment"], row["seeds"]) for row in rows} == {
        ("ddpg", "MassPoint", "0")
    }
    assert {row["horizon"] for row in rows if row["diagnostic"] == "growth"} >= {"1", "32"}
    d3pg("diagnose", sweep, "--figure", "growth", "-o", str(picture), "--environment", "MassPoint")
    assert picture.read_bytes().startswith(b"<?xml")


def test_where_nothing_was_found_the_exit_code_is_1(d3pg: Command, sweep: str) -> None:
    refusal = d3pg("diagnose", f"{sweep}-1", code=1).exception
    assert isinstance(refusal, ServiceError)
    assert "has no policy" in str(refusal)


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("a-1", "--seeds", "2"), "a-1 is a run"),
        (("a", "-o", "x.svg"), "must end in .csv, or name a figure"),
        (("a", "--figure", "loss"), "ends in .png, .svg or .pdf"),
        (("a", "--figure", "loss", "-o", "x.csv"), "ends in .png, .svg or .pdf"),
    ],
)
def test_a_wrong_call_is_a_sentence(d3pg: Command, arguments: list[str], reason: str) -> None:
    said = d3pg("diagnose", *arguments, code=2).stderr
    assert reason in " ".join(said.replace("│", " ").split())


def test_the_client_waits_no_longer_than_asked(
    service: Client, sweep: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("service.api.diagnoser.Diagnoser.ask", lambda *_: None)
    assert service.diagnose(sweep).waiting == 0  # nothing was asked for
    monkeypatch.undo()
    found = service.diagnose(f"{sweep}-0", poll_seconds=0.01)
    assert found == service.diagnosis(f"{sweep}-0")
    assert found.done == 1
