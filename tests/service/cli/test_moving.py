"""Moves of sweeps and runs from the command line."""

from service.client import Client, ServiceError
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import SWEEP


def test_a_sweep_is_paused_resumed_and_cancelled(d3pg: Command, service: Client) -> None:
    sweep = service.submit(SWEEP).id
    assert d3pg("pause", sweep).stdout == f"{sweep}: paused (12 paused)\n"
    assert d3pg("resume", sweep).stdout == f"{sweep}: queued (12 queued)\n"
    assert as_json(d3pg("cancel", sweep, "--json"))["runs"]["cancelled"] == 12


def test_a_run_is_moved_alone(d3pg: Command, service: Client) -> None:
    sweep = service.submit(SWEEP).id
    run = next(service.runs(sweep)).id
    assert d3pg("pause", run).stdout == f"{run}: paused\n"
    assert d3pg("resume", run).stdout == f"{run}: queued\n"
    assert as_json(d3pg("cancel", run, "--json"))["status"] == "cancelled"
    assert service.sweep(sweep).runs.cancelled == 1


def test_an_impossible_move_says_why(d3pg: Command, service: Client) -> None:
    sweep = service.submit(SWEEP).id
    d3pg("cancel", sweep)
    refusal = d3pg("retry", sweep, code=1).exception
    assert isinstance(refusal, ServiceError)
    assert refusal.status == 409
    assert "cancelled" in str(refusal)
