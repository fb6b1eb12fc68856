"""`ls` and `show`: for programs lines with tabs, JSON on demand."""

from service.client import Client
from service.store.store import Store
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import SWEEP, changed
from tests.service.training import RANDOM, random_return, rising, train
from workers.messages.progress import Activity, Progress, Resumption


def test_sweeps_are_lines_newest_first(d3pg: Command, service: Client) -> None:
    first = service.submit(changed(name="[red]tab\there"))
    second = service.submit(changed(name="two"))
    heading, *lines = d3pg("ls").stdout.splitlines()
    assert heading.split("\t")[:3] == ["sweep", "status", "done"]
    assert [line.split("\t")[0] for line in lines] == [second.id, first.id]
    assert lines[1].split("\t")[4:9] == [
        "12 queued",
        lines[1].split("\t")[5],
        "[red]tab here",
        "ddpg, hybrid-ddpg",
        "MassPoint, Pendulum",
    ]
    assert as_json(d3pg("ls", "--json"))["items"][0]["id"] == second.id


def test_a_longer_list_says_that_it_goes_on(d3pg: Command, service: Client) -> None:
    for _ in range(2):
        service.submit(SWEEP)
    result = d3pg("ls", "--limit", "1")
    assert len(result.stdout.splitlines()) == 2
    assert "more than 1" in result.stderr


def test_runs_are_filtered(d3pg: Command, service: Client, store: Store) -> None:
    sweep = service.submit(SWEEP)
    chosen = d3pg("ls", sweep.id, "--algorithm", "ddpg", "--environment", "Pendulum")
    _, *lines = chosen.stdout.splitlines()
    assert [line.split("\t")[5:8] for line in lines] == [
        ["Pendulum", str(seed), "0/4000"] for seed in range(3)
    ]
    train(store, 5, rising)
    assert len(as_json(d3pg("ls", sweep.id, "--status", "succeeded", "--json"))["items"]) == 12
    assert len(d3pg("ls", sweep.id, "--status", "failed").stdout.splitlines()) == 1


def test_sweeps_are_searched(d3pg: Command, service: Client) -> None:
    found = service.submit(changed(name="Horizons", tags=["paper"], algorithms=[{"name": "sac"}]))
    other = service.submit(changed(name="other"))
    for option in (("-q", "horizon"), ("--tag", "paper"), ("--algorithm", "sac")):
        assert [each["id"] for each in as_json(d3pg("ls", *option, "--json"))["items"]] == [
            found.id
        ]
    service.edit(other.id, archived=True)
    assert d3pg("ls").stdout.count(other.id) == 0
    assert d3pg("ls", "--archived").stdout.count(other.id) == 1
    assert "are for sweeps" in d3pg("ls", found.id, "--tag", "paper", code=2).stderr
    assert "status: Input should be" in str(d3pg("ls", "--status", "nope", code=1).exception)


def test_a_row_tells_the_best_curve(d3pg: Command, service: Client, store: Store) -> None:
    for environment in ("MassPoint", "Pendulum"):
        store.record_random_return(random_return(environment, RANDOM))
    service.submit(SWEEP)
    assert "in MassPoint)" not in d3pg("ls").stdout
    train(store, 5, rising)
    assert "(hybrid-ddpg in MassPoint)" in d3pg("ls").stdout


def test_a_sweep_and_a_run_are_shown(d3pg: Command, service: Client, store: Store) -> None:
    sweep = service.submit(SWEEP)
    assert "runs       12: 12 queued" in d3pg("show", sweep.id).stdout
    assert as_json(d3pg("show", sweep.id, "--json"))["name"] == "small"
    train(store, 5, rising)
    run = next(service.runs(sweep.id))
    shown = d3pg("show", run.id).stdout
    assert "status     succeeded\n" in shown
    assert "timestep   4,000 of 4,000" in shown
    assert "attempt 1  succeeded on worker" in shown
    assert as_json(d3pg("show", run.id, "--json"))["seed"] == 0


def test_a_run_says_while_its_kernels_are_loaded_or_compiled(
    d3pg: Command, service: Client, store: Store
) -> None:
    sweep_id = service.submit(SWEEP).id
    claim = store.claim_cohort("worker", 60.0, limit=1)
    assert claim is not None
    remark = "its kernels are loaded, or compiled at first use"
    told = (
        Progress(0, Activity.COMPILING),
        Progress(0, Activity.COMPILING, resumed=(Resumption(0, 0),), fingerprint={"code": "x"}),
    )
    for progress in told:
        store.record(claim, progress)
        assert f"status     running: {remark}\n" in d3pg("show", f"{sweep_id}-0").stdout
        assert d3pg("ls", sweep_id).stdout.count(remark) == 1
    store.record(claim, Progress(50))
    assert "status     running\n" in d3pg("show", f"{sweep_id}-0").stdout
    assert remark not in d3pg("ls", sweep_id).stdout


def test_a_run_tells_where_it_was_taken_up(d3pg: Command, service: Client, store: Store) -> None:
    run_id = f"{service.submit(SWEEP).id}-0"
    first = store.claim_cohort("worker-1", 60.0, limit=1)
    assert first is not None
    store.release(first, "the service was stopped")
    second = store.claim_cohort("worker-2", 60.0, limit=1)
    assert second is not None
    damaged = "newest checkpoint damaged, resumed from step 2400"
    taken_up = Resumption(0, 2400, note=damaged)
    store.record(second, Progress(2400, resumed=(taken_up,), fingerprint={"code": "x"}))
    shown = d3pg("show", run_id).stdout
    assert "attempt 1  lost on worker-1\nthe service was stopped\n" in shown
    assert f"attempt 2  running on worker-2, from timestep 2,400\n{damaged}\n" in shown
