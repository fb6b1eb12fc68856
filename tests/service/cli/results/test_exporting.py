"""What was measured, as files."""

import csv
import io
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from service.client import Client
from service.store.store import Store
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import changed
from tests.service.training import RANDOM, measured, random_return, rising, train, trained_sweep
from workers.messages.progress import Progress


@pytest.fixture
def trained(service: Client, store: Store) -> str:
    return trained_sweep(service, store)


def test_every_measurement_is_a_line(d3pg: Command, service: Client, trained: str) -> None:
    rows = list(csv.DictReader(io.StringIO(d3pg("export", trained).stdout)))
    assert len(rows) == 12 * 5
    assert list(rows[0])[:9] == [
        "run", "label", "algorithm", "environment", "w1", "w2", "config", "seed", "timestep"
    ]  # fmt: skip
    run = service.run(rows[-1]["run"])
    assert (rows[-1]["algorithm"], rows[-1]["seed"]) == (run.algorithm, str(run.seed))
    assert (rows[-1]["label"], json.loads(rows[-1]["config"])) == (run.label, run.config)
    columns = service.measurements(run.id).columns
    own = [row for row in rows if row["run"] == run.id]
    assert [float(row["return_mean"]) for row in own] == columns["return_mean"]


def test_a_run_is_exported_alone_and_to_a_file(
    d3pg: Command, service: Client, trained: str, tmp_path: Path
) -> None:
    run = next(service.runs(trained)).id
    file = tmp_path / "run.csv"
    assert "Wrote 5 measurements" in d3pg("export", run, "-o", str(file)).stdout
    assert file.read_bytes().count(b"\r\n") == 6
    assert as_json(d3pg("export", run, "--json"))["run_id"] == run


def test_a_sweep_is_written_for_other_tools(
    d3pg: Command, service: Client, trained: str, tmp_path: Path
) -> None:
    file = tmp_path / "bench.npz"
    told = d3pg("export", trained, "--format", "openrlbenchmark", "-o", str(file)).stdout
    assert told == f"Wrote 16 arrays to {file}: numpy.load('{file}') reads them\n"
    cell = "Pendulum/ddpg/charts/episodic_return"
    run = next(service.runs(trained, algorithm="ddpg", environment="Pendulum"))
    columns = service.measurements(run.id).columns
    with np.load(file) as read:
        assert read[cell][run.seed].tolist() == columns["return_mean"]
    scores = tmp_path / "scores.npz"
    d3pg("export", trained, "--format", "rliable", "-o", str(scores), "--json")
    with np.load(scores) as read:
        reached, tasks = read["scores/ddpg"], read["tasks"].tolist()
    assert reached.shape == (3, 2)
    final = {run.seed: run.score for run in service.runs(trained, algorithm="ddpg")
             if run.environment == "Pendulum"}  # fmt: skip
    column = reached[:, tasks.index("Pendulum")]
    assert column.tolist() == pytest.approx([final[s] for s in range(3)])


def test_a_form_that_cannot_be_written_says_why(
    d3pg: Command, service: Client, trained: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = next(service.runs(trained)).id
    assert "csv alone" in d3pg("export", run, "--format", "rliable", "-o", "x", code=2).stderr
    assert "name a file" in d3pg("export", trained, "--format", "wandb", code=2).stderr
    (tmp_path / "there").write_text("mine", encoding="utf-8")
    asked = ("--format", "tensorboard", "-o", str(tmp_path))
    assert "name a new folder" in d3pg("export", trained, *asked, code=2).stderr
    for name in ("wandb", "pyarrow"):
        monkeypatch.setitem(sys.modules, name, None)
    for name in ("export.wandb_runs", "api.schemas.measured.measurements_parquet"):
        monkeypatch.delitem(sys.modules, f"service.{name}", raising=False)
    refused = d3pg("export", trained, "--format", "wandb", "-o", str(tmp_path / "w"), code=1)
    assert "pip install 'd3pg[wandb]'" in str(refused.exception)
    refused = d3pg("export", trained, "-o", str(tmp_path / "x.parquet"), code=1)
    assert "pip install 'd3pg[parquet]'" in str(refused.exception)


def test_the_table_in_every_form(d3pg: Command, trained: str) -> None:
    heading, *lines = d3pg("table", trained).stdout.splitlines()
    assert heading == "learner\tMassPoint\tPendulum"
    assert len(lines) == 3
    assert any("*" in line for line in lines)
    assert "95 %" in lines[-1]
    assert as_json(d3pg("table", trained, "--json"))["normalized"] is True
    assert d3pg("table", trained, "--format", "latex").stdout.startswith("\\begin{table}")
    assert "|" in d3pg("table", trained, "--format", "markdown").stdout
    assert "is_best" in d3pg("table", trained, "--format", "csv").stdout
    history = d3pg("table", trained, "--score", "return_history").stdout
    assert "mean of the latest 100 return_mean" in history
    assert "the last tenth of the run's timesteps" in d3pg("table", trained).stdout
    raw = as_json(d3pg("table", trained, "--raw", "--json"))
    assert raw["normalized"] is False


@pytest.mark.parametrize(
    ("form", "start"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")]
)
def test_a_figure_is_saved(
    d3pg: Command, trained: str, tmp_path: Path, form: str, start: bytes
) -> None:
    file = tmp_path / f"figure.{form}"
    assert (
        d3pg("plot", trained, "-o", str(file)).stdout == f"Wrote {file} and {tmp_path}/figure.csv\n"
    )
    assert file.read_bytes().startswith(start)


@pytest.mark.parametrize("command", ["plot", "figure"])
def test_a_figure_s_numbers_replace_no_other_file(
    d3pg: Command, trained: str, tmp_path: Path, command: str
) -> None:
    file, data = tmp_path / "x.png", tmp_path / "x.csv"
    for other in ("mine,not,theirs\n1,2,3\n", "", "metric"):
        data.write_text(other, encoding="utf-8")
        refused = d3pg(command, trained, "-o", str(file), code=2).stderr
        assert "which has other columns" in " ".join(refused.replace("│", " ").split())
        assert data.read_text(encoding="utf-8") == other
        assert not file.exists()
    data.unlink()
    for _ in range(2):  # its own are replaced
        d3pg(command, trained, "-o", str(file))
    assert data.read_text(encoding="utf-8").startswith("metric,environment,entry,")


def test_a_sweep_s_csv_is_passed_on_as_it_arrives(
    d3pg: Command, service: Client, trained: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = service.sweep_csv(trained)
    assert "".join(service.sweep_csv_parts(trained)) == whole
    monkeypatch.setattr(Client, "sweep_csv", None)
    assert d3pg("export", trained).stdout_bytes.decode() == whole


def test_a_figure_of_the_paper_is_saved(d3pg: Command, trained: str, tmp_path: Path) -> None:
    file = tmp_path / "four.svg"
    d3pg("plot", trained, "-o", str(file), "--figure", "4")
    assert b"Figure 4" in file.read_bytes()
    rows = list(csv.DictReader(io.StringIO((tmp_path / "four.csv").read_text(encoding="utf-8"))))
    assert {row["metric"] for row in rows} == {"return_mean", "return_history"}
    assert (
        "fixed scale"
        in d3pg("plot", trained, "-o", str(file), "--figure", "4", "--raw", code=2).stderr
    )


def test_the_table_says_how_many_runs_count(d3pg: Command, service: Client, store: Store) -> None:
    store.record_random_return(random_return("Pendulum", RANDOM))
    sweep = service.submit(changed(algorithms=[{"name": "ddpg"}], environments=["Pendulum"])).id
    claim = store.claim_cohort("worker", 60.0)
    assert claim is not None
    measurements = tuple(measured(spec, 4000, rising(spec, 4000)) for spec in claim.specs)
    store.record(claim, Progress(4000, measurements=measurements, finished=(0, 1)))
    _, row, definition = d3pg("table", sweep).stdout.splitlines()
    assert row.endswith(" (2 of 3)")
    assert "*" not in row
    assert "1 of 3 runs do not count (1 running)" in definition


def test_entries_are_told_apart_in_every_list(d3pg: Command, service: Client, store: Store) -> None:
    entries = [{"name": "ddpg"}, {"name": "ddpg", "config": {"noise": 0.1}}]
    sweep = service.submit(changed(algorithms=entries, seeds=1)).id
    train(store, 5, rising)
    labels = ["ddpg", "ddpg noise=0.1"]
    _, *listed = d3pg("ls", sweep).stdout.splitlines()
    assert [line.split("\t")[2] for line in listed] == labels * 2
    assert "learners   ddpg, ddpg noise=0.1\n" in d3pg("show", sweep).stdout
    assert "learner    ddpg noise=0.1\n" in d3pg("show", f"{sweep}-1").stdout
    rows = list(csv.DictReader(io.StringIO(d3pg("export", sweep).stdout)))
    assert list(dict.fromkeys(row["label"] for row in rows)) == labels
    _, *table, _ = d3pg("table", sweep).stdout.splitlines()
    assert [line.split("\t")[0] for line in table] == labels
    assert all("-" not in line.split("\t") for line in table)


def test_a_figure_for_a_paper_has_its_numbers_beside_it(
    d3pg: Command, trained: str, tmp_path: Path
) -> None:
    file = tmp_path / "paper.pdf"
    asked = ("--metric", "return_mean", "--environment", "Pendulum", "--columns", "1", "--no-title")
    told = as_json(d3pg("figure", trained, "-o", str(file), *asked, "--json"))
    assert told == {"file": str(file), "data": str(tmp_path / "paper.csv")}
    assert file.read_bytes().startswith(b"%PDF")
    data = (tmp_path / "paper.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(data)))
    assert {(row["metric"], row["environment"]) for row in rows} == {("return_mean", "Pendulum")}
