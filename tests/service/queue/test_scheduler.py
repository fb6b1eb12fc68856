"""The scheduler in a simulated world: whatever happens, in whatever order, its promises hold.

`D3PG_SIMULATED_STEPS=1000000 pytest tests/service/queue/test_scheduler.py` simulates for longer;
`D3PG_SIMULATED_SEED=17 pytest tests/service/queue/test_scheduler.py` replays one world.
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest
from sqlalchemy import Connection, Row

from service.model.claim import Claim
from service.model.move import TRANSITIONS, Move
from service.model.run import FINAL, RunStatus
from service.model.run_name import RunName
from service.queue.dispatch_state import DispatchTimes, State
from service.queue.messages import (
    ClaimCohort,
    Claimed,
    Command,
    Demand,
    QueueEvent,
    Release,
    Tick,
    Waiting,
)
from service.queue.scheduler import NO_ROOM, WORKERS_STARTING, step
from service.store import records
from service.store.claiming import claims, endings, moves
from service.store.tables import is_running
from tests.service.simulation import Simulation
from workers.messages.assignment import Assignment
from workers.messages.report import Busy, Capacity, Lost, Ready, Report, Retired
from workers.messages.run_spec import RunSpec
from workers.messages.work import Work

STEPS = int(os.environ.get("D3PG_SIMULATED_STEPS", "4000"))
STEPS_OF_THE_LONG_TEST = 100_000
STEPS_A_WORLD = 1000
REPLAYED = os.environ.get("D3PG_SIMULATED_SEED")

pytestmark = pytest.mark.timeout(0)


def simulate(seed: int) -> int:
    """Simulate one world; says how to see a failure again."""
    print(f"seed {seed}")  # noqa: T201  (shown whatever it is that ends the test)
    simulation = Simulation(seed)
    try:
        simulation.run(STEPS_A_WORLD)
    except Exception as failure:
        story = "\n".join(simulation.story)
        raise AssertionError(
            f"{failure}\nafter step {simulation.steps} of seed {seed}; the last events:\n{story}\n"
            f"again: D3PG_SIMULATED_SEED={seed} pytest tests/service/queue/test_scheduler.py"
        ) from failure
    finally:
        simulation.close()
    return simulation.steps


def simulate_worlds(first_seed: int, steps: int) -> None:
    """Simulate one world after the other until so many things have happened."""
    done, seed = 0, first_seed
    while done < steps:
        done += simulate(seed)
        seed += 1


def test_any_order_of_events_keeps_every_promise() -> None:
    if REPLAYED is not None:
        simulate(int(REPLAYED))
    else:
        simulate_worlds(0, STEPS)


@pytest.mark.slow
def test_a_hundred_thousand_events_keep_every_promise() -> None:
    simulate_worlds(1000, STEPS_OF_THE_LONG_TEST)


def test_what_a_worker_said_of_an_earlier_cohort_displaces_none() -> None:
    state, _ = step(State(), Busy("a", Work("new-0/1", ())), 0.0, DispatchTimes())
    repeated, commands = step(state, Busy("a", Work("old-0/1", ())), 1.0, DispatchTimes())
    assert (repeated.cohorts, commands) == (state.cohorts, [])


def told(state: State, *events: QueueEvent) -> tuple[State, list[Command]]:
    """The state after events, and all that was commanded."""
    commands: list[Command] = []
    for event in events:
        state, more = step(state, event, 0.0, DispatchTimes())
        commands += more
    return state, commands


def test_says_whether_the_cluster_has_room_for_workers() -> None:
    ready, lost = Ready("a", 1, "here"), Lost("a", "its node is gone", "")
    standing: list[tuple[Report, str]] = [
        (Capacity(0, slots=0), NO_ROOM),
        (Capacity(2, slots=1), WORKERS_STARTING),
        (ready, ""),
        (Capacity(1, slots=1), ""),
        (lost, ""),
        (Capacity(0, slots=0), NO_ROOM),
        (Capacity(9, slots=0), ""),  # they come when there is work
    ]
    state = State()
    for report, problem in standing:
        state, _ = told(state, report)
        assert state.problem == problem, report


def waiting(*cells: int, limit: int = 10_000) -> Waiting:
    return Waiting(cells, limit, frozenset())


def test_a_cell_is_split_over_free_cores_though_only_one_worker_is_up() -> None:
    state, _ = told(State(), Tick(), Capacity(8, slots=1), Ready("a", 1, "here"))
    state, commands = told(state, waiting(16))
    assert commands == [Demand(8), ClaimCohort("a", DispatchTimes().lease, 2)]


def test_more_is_demanded_than_there_is_room_for_until_nothing_waits() -> None:
    busy = Busy("a", Work("x-0/1", ()))
    state, _ = told(State(), Tick(), Capacity(1, slots=1), busy)
    state, commands = told(state, waiting(16, 16, 5))
    assert commands == [Demand(4)]
    assert told(state, waiting(16, 16, 5))[1] == []  # the pool knows
    assert told(state, waiting(16, limit=16))[1] == []  # more may wait than was counted
    assert told(state, waiting())[1] == [Demand(1)]
    assert told(State(), Tick(), waiting())[1][-1] == Demand(0)  # as far as this pool was told


def test_what_a_retired_worker_was_given_is_put_back_at_once() -> None:
    claim = Claim("a", 15.0, (Assignment("x-0", 1, RunSpec("ddpg", "Pendulum", 0), 1),))
    state, _ = told(State(), Ready("a", 1, "here"), Claimed("a", claim))
    state, commands = told(state, Retired("a"))
    assert commands == [Release(claim, "its worker was retired before the run began")]
    assert (state.idle, state.cohorts) == ((), {})


# ---- a store that lacks one of its fences is found out


def test_late_writes_of_earlier_attempts_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    def held_under_any_attempt(
        connection: Connection, held: Sequence[Claim]
    ) -> list[dict[str, Row[Any]]]:
        return [
            {n: row for n, row in rows_of(connection, claim).items() if row.status == "running"}
            for claim in held
        ]

    for module in (records, endings):
        monkeypatch.setattr(module, "held_runs", held_under_any_attempt)
    assert_noticed("was changed by what may not")


def test_writes_to_runs_that_have_ended_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    def held_for_ever(connection: Connection, held: Sequence[Claim]) -> list[dict[str, Row[Any]]]:
        attempts = {(run.run_id, run.attempt) for claim in held for run in claim.runs}
        return [
            {
                n: row
                for n, row in rows_of(connection, claim).items()
                if (n, row.attempt) in attempts
            }
            for claim in held
        ]

    monkeypatch.setattr(endings, "held_runs", held_for_ever)
    assert_noticed("was changed by what may not")


def test_ends_of_leases_that_have_not_ended_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (claims, endings):
        monkeypatch.setattr(module, "has_ended", is_running)
    assert_noticed("was changed by what may not")


def test_cancelling_what_has_ended_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    extend(monkeypatch, "cancel", frozenset(RunStatus) - {RunStatus.RUNNING})
    assert_noticed("and became cancelled")


def test_trying_again_what_did_not_fail_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    extend(monkeypatch, "retry", FINAL)
    assert_noticed("and became queued")


def extend(monkeypatch: pytest.MonkeyPatch, asked: Move, sources: frozenset[RunStatus]) -> None:
    """Let a move start where it may not, once it is not refused."""
    transitions = {**TRANSITIONS, asked: replace(TRANSITIONS[asked], sources=sources)}
    monkeypatch.setattr(moves, "TRANSITIONS", transitions)


def rows_of(connection: Connection, claim: Claim) -> dict[str, Row[Any]]:
    """The claim's runs that there still are, whether or not they are its own."""
    rows = connection.execute(claims.held_rows()).all()
    found = {str(RunName(row.sweep_id, row.ordinal)): row for row in rows}
    return {run.run_id: found[run.run_id] for run in claim.runs if run.run_id in found}


def assert_noticed(how: str) -> None:
    """The worlds of the test above are enough."""
    with pytest.raises(AssertionError, match=how):
        simulate_worlds(0, 12_000)
