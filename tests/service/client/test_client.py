"""The client: typed answers, refusals as sentences, nothing heavy loaded."""

import json
import ssl
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, get_args

import httpx2
import numpy as np
import pytest
from fastapi import FastAPI

from service.api.schemas.requests.sweep_request import SweepRequest
from service.api.schemas.sweep_answer import SweepAnswer
from service.client import Client, ServiceError, SubmissionNotice, trusted
from service.model.move import Move
from service.store.store import Store
from tests.docs.pages import ROOT, blocks
from tests.service.certificate import self_signed
from tests.service.conftest import SWEEP, TOKEN, changed
from tests.service.served import served
from tests.service.training import RANDOM, random_return, rising, train, trained_sweep
from workers.messages.progress import Progress


@pytest.fixture
def service(app: FastAPI) -> Iterator[Client]:
    """A client of a real server."""
    with served(app) as url, Client(url, TOKEN) as client:
        yield client


@pytest.fixture
def trained(service: Client, store: Store) -> str:
    return trained_sweep(service, store)


def test_it_loads_neither_numba_nor_torch_nor_ray() -> None:
    code = (
        "import sys, service.client\n"
        "print(*{'numba', 'torch', 'ray', 'matplotlib'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_this_machine_is_asked_past_proxies(app: FastAPI, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HTTP_PROXY", "http_proxy", "ALL_PROXY", "all_proxy"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    monkeypatch.delenv("NO_PROXY", raising=False)
    with served(app) as url, Client(url, TOKEN) as client:
        assert client.readiness().status == "ready"
    with Client("http://lab.example", TOKEN) as client, pytest.raises(ServiceError):
        client.readiness()


@pytest.mark.parametrize(("host", "url"), [("", "http://127.0.0.1:81"), ("::1", "http://[::1]:81")])
def test_it_reads_the_settings_that_the_service_reads(
    monkeypatch: pytest.MonkeyPatch, host: str, url: str
) -> None:
    monkeypatch.delenv("D3PG_URL", raising=False)
    monkeypatch.setenv("D3PG_HOST", host)
    monkeypatch.setenv("D3PG_PORT", "81")
    assert Client(token=TOKEN).url == url


@pytest.mark.parametrize(
    ("public_url", "url"),
    [("", "https://127.0.0.1:81"), ("https://lab.example/d3pg", "https://lab.example/d3pg")],
)
def test_it_finds_a_service_that_speaks_tls_and_trusts_its_certificate(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, public_url: str, url: str
) -> None:
    """A certificate is for a name, which only the public address has."""
    certificate, _ = self_signed(tmp_path, "DNS:lab.example")
    monkeypatch.delenv("D3PG_URL", raising=False)
    monkeypatch.setenv("D3PG_PORT", "81")
    monkeypatch.setenv("D3PG_TLS_CERTIFICATE", str(certificate))
    monkeypatch.setenv("D3PG_PUBLIC_URL", public_url)
    assert Client(token=TOKEN).url == url
    trust = trusted()
    assert isinstance(trust, ssl.SSLContext)
    assert any("lab.example" in str(each) or "here" in str(each) for each in trust.get_ca_certs())


def test_a_model_and_a_mapping_are_submitted_alike(service: Client) -> None:
    of_mapping = service.submit(SWEEP)
    of_model = service.submit(SweepRequest.model_validate(SWEEP))
    assert of_mapping.request == of_model.request == SWEEP
    assert of_mapping.id != of_model.id
    assert [sweep.id for sweep in service.sweeps()] == [of_model.id, of_mapping.id]
    assert service.sweep(of_model.id) == of_model


def test_notices_of_a_submission_are_warnings(service: Client) -> None:
    request = changed(algorithms=[{"name": "hybrid-ddpg", "weights": {"w1": 0, "w2": 0}}])
    with pytest.warns(SubmissionNotice, match="it is ddpg, bit for bit"):
        sweep = service.submit(request)
    assert service.estimate(request).notices == sweep.notices


def test_an_estimate_queues_nothing(service: Client) -> None:
    answer = service.estimate(SWEEP)
    assert answer.runs.total == 12
    assert [cell.seeds for cell in answer.cells] == [3] * 4
    assert list(service.sweeps()) == []


def test_under_the_same_key_it_is_the_same_sweep(service: Client) -> None:
    first = service.submit(SWEEP, key="mine")
    assert service.submit(SWEEP, key="mine").id == first.id
    with pytest.raises(ServiceError, match="submitted under this key") as refusal:
        service.submit(changed(seeds=1), key="mine")
    assert refusal.value.status == 422


def test_an_answer_that_was_lost_is_asked_for_once_more(
    service: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    request, asked = service._http.request, []

    def losing(*arguments: object, **options: object) -> httpx2.Response:
        response = request(*arguments, **options)  # type: ignore[arg-type]
        asked.append(response)
        if len(asked) == 1:
            raise httpx2.ReadError("the connection was cut")
        return response

    monkeypatch.setattr(service._http, "request", losing)
    sweep = service.submit(SWEEP)
    assert [json.loads(response.content)["id"] for response in asked] == [sweep.id] * 2


def test_runs_come_page_after_page(service: Client) -> None:
    sweep = service.submit(changed(seeds=5))
    runs = list(service.runs(sweep.id, limit=3))
    assert len({run.id for run in runs}) == len(runs) == 20
    assert {run.algorithm for run in service.runs(sweep.id, algorithm="ddpg")} == {"ddpg"}


def test_a_sweep_and_a_run_are_moved(service: Client) -> None:
    sweep = service.submit(SWEEP)
    run = next(service.runs(sweep.id))
    assert service.move(run.id, "cancel").status == "cancelled"
    assert service.move(sweep.id, "pause").status == "paused"
    with pytest.raises(ServiceError) as refusal:
        service.move(run.id, "resume")
    assert refusal.value.status == 409


def test_curves_become_an_array(service: Client, trained: str) -> None:
    curves = service.curves(trained, metric="return_mean", seeds=True)
    (panel,) = (panel for panel in curves.panels if panel.environment == "Pendulum")
    values = np.array([[s.values for s in curve.seeds or []] for curve in panel.curves], float)
    assert values.shape == (2, 3, 5)
    means = np.array([curve.mean for curve in panel.curves], float)
    np.testing.assert_allclose(values.mean(axis=1), means)


def test_measurements_table_and_figure(service: Client, trained: str) -> None:
    run = next(service.runs(trained))
    measured = service.measurements(run.id)
    assert measured.columns["timestep"] == [800, 1600, 2400, 3200, 4000]
    assert service.measurements_csv(run.id).startswith("timestep,return_mean")
    assert [attempt.outcome for attempt in service.attempts(run.id)] == ["succeeded"]
    assert service.table(trained).environments == ["MassPoint", "Pendulum"]
    assert "\\begin{tabular}" in service.table_text(trained, "latex")
    assert service.figure(trained, "pdf").startswith(b"%PDF")
    assert service.figure(trained, "png", "4").startswith(b"\x89PNG")


def test_waiting_ends_with_the_sweep_or_the_timeout(service: Client, trained: str) -> None:
    seen: list[float] = []
    ended = service.wait(trained, progressed=lambda sweep: seen.append(sweep.progress))
    assert ended.runs.succeeded == 12
    assert seen == [1.0]
    waiting = service.submit(SWEEP)
    with pytest.raises(TimeoutError, match=waiting.id):
        service.wait(waiting.id, timeout_seconds=0, poll_seconds=0)


def test_a_log_is_followed_while_the_service_is_away(
    service: Client, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id = f"{service.submit(SWEEP).id}-0"
    claim = store.claim_cohort("worker", 60.0)
    assert claim is not None
    seeds = tuple(spec.seed for spec in claim.specs)
    store.record(claim, Progress(4000, log_tail="all of it\n", finished=seeds))
    request, asked = service._http.request, []

    def often_away(*arguments: object, **options: object) -> httpx2.Response:
        asked.append(arguments)
        if len(asked) in {1, 3}:
            raise httpx2.ConnectError("refused")
        return request(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(service._http, "request", often_away)
    [attempt] = service.follow_log(run_id, poll_seconds=0)
    assert (attempt.outcome, attempt.log_tail) == ("succeeded", "all of it\n")
    assert len(asked) == 5


def test_a_refusal_names_every_fault_once(service: Client) -> None:
    with pytest.raises(ServiceError) as refusal:
        service.submit(changed(environments=["Pendulun"], algorithms=[{"name": "dpg"}]))
    assert refusal.value.status == 422
    for text in ("2 things are wrong:", "environments[0]", "algorithms[0].name"):
        assert str(refusal.value).count(text) == 1
    with pytest.raises(ServiceError, match=r"^algorithms\[0\].name: unknown .*$"):
        service.submit(changed(algorithms=[{"name": "dpg"}]))


def test_readiness_tells_what_is_missing(app: FastAPI, service: Client) -> None:
    assert service.readiness().status == "ready"
    app.state.dispatcher.problem = "the cluster is starting"
    assert [check.problem for check in service.readiness().checks][-1] == "the cluster is starting"


def test_what_the_clients_page_shows_runs(
    service: Client, store: Store, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """docs/client.md, with workers that train as soon as a sweep is submitted."""
    submit = Client.submit

    def submit_and_train(client: Client, request: Mapping[str, Any]) -> SweepAnswer:
        sweep = submit(client, request)
        store.record_random_return(random_return("Pendulum", RANDOM))
        train(store, 5, rising)
        return sweep

    monkeypatch.setattr(Client, "submit", submit_and_train)
    monkeypatch.setenv("D3PG_URL", service.url)
    monkeypatch.setenv("D3PG_TOKEN", TOKEN)
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.chdir(tmp_path)
    (shown,) = blocks(ROOT / "docs" / "client.md", "python")
    names: dict[str, Any] = {}
    exec(compile(shown, "client.md", "exec"), names)  # noqa: S102
    names["client"].close()
    names["plt"].close()
    assert names["values"].shape == (16, 5)
    assert (tmp_path / "curves.png").stat().st_size > 0


def test_what_one_sees_at_a_prompt_names_it(service: Client) -> None:
    sweep = service.submit(SWEEP)
    assert repr(sweep) == f"<sweep {sweep.id} 'small' queued, 12 runs, 0%>"
    run = service.run(f"{sweep.id}-1")
    assert repr(run) == f"<run {run.id} ddpg in MassPoint, seed 1, queued, 0/4000>"


def test_each_move_has_a_method_of_its_name(service: Client) -> None:
    sweep_id = service.submit(SWEEP).id
    assert repr(service.pause(sweep_id)).count("paused")
    assert repr(service.resume(sweep_id)).count("queued")
    assert repr(service.cancel(f"{sweep_id}-0")).count("cancelled")
    assert repr(service.uncancel(f"{sweep_id}-0")).count("queued")
    service.cancel(f"{sweep_id}-0")
    with pytest.raises(ServiceError, match="only failed runs"):
        service.retry(f"{sweep_id}-0")
    for name in get_args(Move):
        assert callable(getattr(Client, name))


def test_the_score_of_every_run(service: Client, trained: str) -> None:
    answer = service.scores(trained)
    assert {(cell.environment, cell.label) for cell in answer.cells} == {
        (task, label) for task in ("MassPoint", "Pendulum") for label in ("ddpg", "hybrid-ddpg")
    }
    table = service.table(trained)
    for cell in answer.cells:
        [row] = [row for row in table.rows if row.label == cell.label]
        standing = row.entries[table.environments.index(cell.environment)]
        assert standing is not None
        assert np.mean(np.array(cell.values, float)) == pytest.approx(standing.mean)
    raw = service.scores(trained, score="return_history", normalized=False)
    assert raw.cells[0].values != answer.cells[0].values


def test_measurements_are_saved_and_read_run_by_run(
    service: Client, trained: str, tmp_path: Path
) -> None:
    file = tmp_path / "all.csv"
    assert service.save_measurements(trained, file) == file.stat().st_size
    assert file.read_bytes().decode() == service.sweep_csv(trained)
    runs = list(service.measured_runs(trained))
    assert [run.id for run in runs] == [run.id for run in service.runs(trained)]
    for run in runs:
        columns = service.measurements(run.id).columns
        assert run.columns["return_mean"].tolist() == columns["return_mean"]
        rows = [row for row in service.sweep_rows(trained) if row["run"] == run.id]
        own = service.measurement_rows(run.id)
        assert [{name: row[name] for name in own[0]} for row in rows] == own
    with pytest.raises(ServiceError, match="no sweep"):
        list(service.measured_runs("000000000000"))


def test_answers_are_tables(service: Client, trained: str) -> None:
    curves = service.curves(trained, seeds=True)
    rows = list(curves.records())
    panel = curves.panels[0]
    curve = panel.curves[0]
    assert curve.seeds is not None
    first = {
        "environment": panel.environment, "label": curve.label, "algorithm": curve.algorithm,
        "timesteps": curve.x[0], "mean": curve.mean[0], "low": curve.low[0], "high": curve.high[0],
        "n": curve.n[0],
    }  # fmt: skip
    seed = curve.seeds[0]
    assert rows[0] == {**first, "seed": 0, "run": seed.run_id, "value": seed.values[0]}
    assert len(rows) == 12 * 5
    assert next(service.curves(trained).records()) == first
    cells = list(service.table(trained).records())
    assert len(cells) == 4
    assert {"environment", "label", "w1", "config", "mean", "is_best"} <= set(cells[0])
    statistics = service.statistics(trained)
    assert [row["label"] for row in statistics.interquartile_mean.records()] == [
        "ddpg", "hybrid-ddpg"
    ]  # fmt: skip
    [pair] = statistics.probability_of_improvement.records()
    assert (pair["x"], pair["y"]) == ("ddpg", "hybrid-ddpg")
    assert len(list(statistics.paired_differences.records())) == 2
    assert len(list(service.scores(trained).records())) == 12


def test_values_that_are_not_finite_come_back_in_tables(service: Client, store: Store) -> None:
    sweep = service.submit(changed(seeds=1, environments=["Pendulum"])).id
    train(store, 2, lambda spec, step: float("-inf") if step == 800 else 1.0)
    run = next(service.runs(sweep))
    values = [row["return_mean"] for row in service.measurements(run.id).records()]
    assert values == [float("-inf"), 1.0]


def test_tables_for_pandas(service: Client, trained: str, monkeypatch: pytest.MonkeyPatch) -> None:
    pandas = pytest.importorskip("pandas", reason="the extra `pandas` is not installed")
    frame = service.to_pandas(trained)
    assert isinstance(frame, pandas.DataFrame)
    assert len(frame) == 12 * 5
    means = frame[frame.timestep == 4000].groupby("label").return_mean.mean()
    assert means["hybrid-ddpg"] > means["ddpg"]
    assert len(service.table(trained).to_pandas()) == 4
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'd3pg\[pandas\]'"):
        service.table(trained).to_pandas()
