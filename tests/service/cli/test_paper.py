"""`d3pg paper`: sweeps that are submitted once, and what they measured as files."""

import csv
import json
from collections import Counter
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from algorithms.presets import preset
from service.client import Client
from service.paper import evaluation
from service.paper.search import tuning
from service.queue.question_rounds import look_at_all
from service.store.store import Store
from tests.service.cli.conftest import Command, as_json
from tests.service.paper.measured_folder import Runs, write_evidence, write_folder
from tests.service.training import RANDOM, at_work, random_return, rising, train

QUICK = ("--seeds", "2", "--scale", "0.001")


def workers(store: Store) -> AbstractContextManager[None]:
    """Whatever is queued is trained at once, and searches are settled."""

    def work() -> None:
        train(store, 2, rising)
        look_at_all(store)

    return at_work(work)


def rows_of(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


@pytest.mark.slow
def test_an_evaluation_is_taken_up_and_written(
    d3pg: Command,
    service: Client,
    store: Store,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one_task = {
        **evaluation.COMPARISON,
        "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg"}, {"name": "mpc"}],
        "environments": ["Pendulum"],
    }
    soft = {**evaluation.SOFT, "environments": ["Pendulum"]}
    today = {**evaluation.LEARNED, "environments": ["Pendulum"]}
    monkeypatch.setattr(evaluation, "SWEEPS", (one_task, evaluation.CRITIC, soft, today))
    store.record_random_return(random_return("Pendulum", RANDOM))
    (of_before := tmp_path / "figure-4.png").write_bytes(b"of an evaluation before this one")
    begun = d3pg("paper", "write", *QUICK, "-o", str(tmp_path)).stdout
    assert not of_before.exists()
    assert f"Wrote {tmp_path}/: 0 of 20 runs reached their end." in begun.replace("\n", "")
    looked = d3pg("paper", "write", *QUICK, "-o", str(tmp_path), "--json")
    assert as_json(looked)["total"] == 20
    with workers(store):
        ended = d3pg("paper", *QUICK, "-o", str(tmp_path)).stdout
    assert "20 of 20 runs reached their end." in ended
    assert "figure 3 is not there yet" in " ".join(ended.split()), "there are no runs for it"
    assert len(list(service.sweeps())) == 4

    [sweep] = [sweep for sweep in service.sweeps() if "all methods" in sweep.name]
    [_, run] = service.runs(sweep.id, algorithm="mpc", environment="Pendulum")
    kept = [
        row for row in rows_of(tmp_path / "measurements/Pendulum/mpc.csv") if row["seed"] == "1"
    ]
    returns = service.measurements(run.id).columns["return_mean"]
    assert [float(row["return_mean"]) for row in kept] == returns
    histories = service.measurements(run.id).columns["return_history"]
    assert [float(row["return_history"]) for row in kept] == histories
    assert {row["compile_seconds"] for row in kept} == {"0.25"}
    assert (tmp_path / "figure-4.png").read_bytes().startswith(b"\x89PNG")
    assert {row["metric"] for row in rows_of(tmp_path / "figure-4.csv")} == {
        "return_mean", "return_history"
    }  # fmt: skip
    assert "hybrid" in (tmp_path / "table-1.md").read_text()

    gains = {
        (row["algorithm"], row["cost"]): row
        for row in rows_of(tmp_path / "gains.csv")
        if row["environment"] == "Pendulum"
    }
    gain = gains["hybrid-ddpg", "timesteps"]
    assert (gain["n"], gain["wins"]) == ("2", "2"), "the longer name earns more"
    assert float(gain["mean"]) == pytest.approx(50 * len("hybrid-") / -RANDOM, rel=1e-4)

    assert gains["hybrid-sac", "timesteps"]["n"] == "2", "of another sweep, in the same table"
    assert {file.stem for file in (tmp_path / "measurements/Pendulum").iterdir()} == {
        "ddpg", "hybrid-ddpg", "mpc", "sac", "hybrid-sac", "sac-with-learned-temperature"
    }  # fmt: skip

    written = (tmp_path / "gains.csv").read_bytes()
    (tmp_path / "gains.csv").unlink()
    (tmp_path / "figure-7.csv").unlink()
    derived = as_json(d3pg("paper", "derive", "-o", str(tmp_path), "--json"))
    assert derived["files"][:2] == [f"{tmp_path}/gains.csv", f"{tmp_path}/figure-7.csv"]
    assert (tmp_path / "gains.csv").read_bytes() == written
    assert {row["learner"] for row in rows_of(tmp_path / "figure-7.csv")} >= {"ddpg", "mpc", "sac"}
    summary = d3pg("paper", "summary", "-o", str(tmp_path)).stdout
    assert "## hybrid-sac minus" in summary
    asked = d3pg("paper", "summary", "-o", str(tmp_path), "--json")
    assert as_json(asked)["markdown"] == summary.removesuffix("\n")

    scores = [
        row
        for row in rows_of(tmp_path / "scores.csv")
        if (row["environment"], row["algorithm"], row["seed"]) == ("Pendulum", "mpc", "1")
    ]
    [(status, reached)] = [(row["status"], row["return_history"]) for row in scores]
    assert (status, float(reached)) == ("succeeded", histories[-1])
    [zero] = [row for row in rows_of(tmp_path / "random-returns.csv") if row["random"]]
    assert (zero["environment"], zero["best"]) == ("Pendulum", "0.0")
    assert [float(zero[name]) for name in ("random", "low", "high")] == [
        RANDOM, RANDOM - 10, RANDOM + 10,
    ]  # fmt: skip

    provenance = json.loads((tmp_path / "provenance.json").read_text())
    assert provenance["sweeps"][sweep.name]["runs"]["succeeded"] == 6
    assert provenance["sweeps"][sweep.name]["core seconds"] > 0
    assert provenance["sweeps"][sweep.name]["compile core seconds"] == round(6 * 0.25)


def test_a_sweep_that_the_folder_has_whole_is_not_trained_by_a_new_service(
    d3pg: Command,
    service: Client,
    store: Store,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    on_policy = {**evaluation.ON_POLICY, "environments": ["Pendulum"]}
    twin = {**evaluation.TWIN, "environments": ["CartPole"]}
    monkeypatch.setattr(evaluation, "SWEEPS", (on_policy, twin))
    store.record_random_return(random_return("CartPole", RANDOM))
    results = tmp_path / "results"
    learners = [
        Runs("Pendulum", name, [5.0, 6.0], preset(name, "Pendulum").config)
        for name in ("ppo", "shac")
    ]
    write_folder(results, [*learners, Runs("CartPole", "ddpg", [1.0])])
    whole, lacking = evaluation.evaluation(2, 0.001)
    write_evidence(results, whole)
    former = (results / "measurements/Pendulum/ppo.csv").read_bytes()

    with workers(store):
        said = " ".join(d3pg("paper", *QUICK, "-o", str(results)).stdout.split())
    assert f"{whole['name']}: whole in" in said
    assert [sweep.name for sweep in service.sweeps()] == [lacking["name"]]
    assert (results / "measurements/Pendulum/ppo.csv").read_bytes() == former
    scores = [(row["environment"], row["algorithm"]) for row in rows_of(results / "scores.csv")]
    assert Counter(scores) == {
        ("Pendulum", "ppo"): 2, ("Pendulum", "shac"): 2,
        ("CartPole", "td3"): 2, ("CartPole", "hybrid-td3"): 2,
    }  # fmt: skip
    zeros = {row["environment"]: row["random"] for row in rows_of(results / "random-returns.csv")}
    assert zeros == {"CartPole": str(RANDOM), "Pendulum": "0.0"}
    for name in ("provenance.json", "statistics.json"):
        document = json.loads((results / name).read_text())
        assert set(document.get("sweeps", document)) == {whole["name"], lacking["name"]}
    assert {row["algorithm"] for row in rows_of(results / "gains.csv")} == {"hybrid-td3"}


def test_tuning_gives_the_hybrids_what_suited_ddpg(
    d3pg: Command,
    service: Client,
    store: Store,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(tuning, "TIMESTEPS", {"Pendulum": 1600})
    store.record_random_return(random_return("Pendulum", RANDOM))
    with workers(store):
        d3pg("paper", "tune", "-o", str(tmp_path))
    rows = rows_of(tmp_path / "tuning.csv")
    assert len(rows) == 6 * (len(tuning.SPACES) + len(tuning.PAIRS))
    settings = next(row for row in rows if row["algorithm"] == "ddpg")
    weights = next(row for row in rows if row["algorithm"] == "hybrid-ddpg-cosine")
    assert json.loads(settings["config"]) == json.loads(weights["config"]), "all are equally good"
    assert settings["runs"] == "4"
    sweeps = {sweep.id for sweep in service.sweeps()}
    assert {row["sweep"] for row in rows} == sweeps

    table = tmp_path / "tuning.csv"
    lines = table.read_text().splitlines(keepends=True)
    table.write_text("".join(line for line in lines if "ddpg-cosine,0.1" not in line))
    with workers(store):
        d3pg("paper", "tune", "-o", str(tmp_path))
    again = rows_of(table)
    assert sorted(map(str, again)) == sorted(map(str, rows)), "each cell once"
    assert {sweep.id for sweep in service.sweeps()} == sweeps, "that search has been made"
