"""In whatever order things happen, the store stays true.

Stale writers change nothing, final states stay, no measurement is lost or doubled. A hypothesis
state machine drives a store beside a plain model of what must be in it; claims live on after they
were given up, and their writers go on writing.
"""

from dataclasses import dataclass, field
from functools import partial

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    Bundle,
    MultipleResults,
    RuleBasedStateMachine,
    consumes,
    initialize,
    invariant,
    multiple,
    precondition,
    rule,
    run_state_machine_as_test,
)

from algorithms.early_end import Divergence
from service.model.claim import Claim
from service.model.move import Move
from service.model.run import ACTIVE, RunStatus
from service.store.refusal import ImpossibleMoveError
from service.store.store import Store
from service.store.upkeep.integrity import check
from tests.service.promises import sweep_of
from tests.service.store.conftest import AT_ONCE, Fresh, measured
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec

TIMESTEPS = 8000
OVER = -1.0


@dataclass
class Expected:
    """What the store must say of a run."""

    status: RunStatus = RunStatus.QUEUED
    attempt: int = 0
    is_cancelling: bool = False
    losses: int = 0
    timesteps: set[int] = field(default_factory=set)


class StoreMachine(RuleBasedStateMachine):
    """Sweeps of one cell each; every rule is something a client, a worker or a crash does."""

    claims: Bundle[Claim] = Bundle("claims")

    def __init__(self, url: str) -> None:
        super().__init__()
        self.url = url

    @initialize()
    def open(self) -> None:
        self.store = Store.open(self.url, AT_ONCE)
        self.runs: dict[str, Expected] = {}

    def teardown(self) -> None:
        self.store.close()

    def held(self, claim: Claim) -> list[str]:
        """The runs of a claim that are still its own."""
        return [
            run.run_id
            for run in claim.runs
            if (known := self.runs.get(run.run_id)) is not None
            and known.status is RunStatus.RUNNING
            and known.attempt == run.attempt
        ]

    @rule(seeds=st.integers(1, 3), priority=st.integers(0, 1))
    def submit(self, seeds: int, priority: int) -> None:
        specs = [RunSpec("ddpg", "Pendulum", seed, timesteps=TIMESTEPS) for seed in range(seeds)]
        sweep = self.store.create_sweep(
            "x", priority, {"seeds": seeds}, specs, environment_versions={"Pendulum": 1}
        )
        self.runs.update({f"{sweep.id}-{ordinal}": Expected() for ordinal in range(seeds)})

    @rule(target=claims, limit=st.integers(1, 3), lease=st.sampled_from([60.0, OVER]))
    def claim(self, limit: int, lease: float) -> "Claim | MultipleResults[Claim]":
        claim = self.store.claim_cohort("w", lease, limit)
        waiting = {name for name, run in self.runs.items() if run.status is RunStatus.QUEUED}
        if claim is None:
            assert not waiting
            return multiple()
        assert {run.run_id for run in claim.runs} <= waiting
        assert len(claim.runs) <= limit
        for claimed in claim.runs:
            run = self.runs[claimed.run_id]
            run.status, run.attempt = RunStatus.RUNNING, run.attempt + 1
            assert claimed.attempt == run.attempt
        return claim

    @rule(claim=claims, cycle=st.integers(1, 10))
    def measure(self, claim: Claim, cycle: int) -> None:
        timestep = 800 * cycle
        taken = tuple(measured(run.spec.seed, timestep) for run in claim.runs)
        held = self.held(claim)
        assert self.store.record(claim, Progress(timestep, measurements=taken)) == set(held)
        for name in held:
            run = self.runs[name]
            if timestep not in run.timesteps:
                run.losses = 0
            run.timesteps.add(timestep)

    @rule(claim=claims, data=st.data())
    def end_some(self, claim: Claim, data: st.DataObject) -> None:
        ends = data.draw(
            st.dictionaries(
                st.sampled_from([run.spec.seed for run in claim.runs]),
                st.sampled_from(["finished", "diverged", "dropped"]),
            )
        )
        named = {how: [s for s, e in ends.items() if e == how] for how in set(ends.values())}
        held = self.held(claim)
        self.store.record(
            claim,
            Progress(
                TIMESTEPS,
                finished=tuple(named.get("finished", ())),
                dropped=tuple(named.get("dropped", ())),
                diverged=tuple(Divergence(s, 1, 1, "loss") for s in named.get("diverged", ())),
            ),
        )
        for claimed in claim.runs:
            how = ends.get(claimed.spec.seed)
            if claimed.run_id not in held or how is None:
                continue
            run = self.runs[claimed.run_id]
            if how == "dropped" and not run.is_cancelling:
                continue
            run.status = {
                "finished": RunStatus.SUCCEEDED,
                "diverged": RunStatus.DIVERGED,
                "dropped": RunStatus.CANCELLED,
            }[how]

    @rule(claim=claims)
    def fail(self, claim: Claim) -> None:
        held = self.held(claim)
        self.store.fail(claim, "ValueError: x")
        for name in held:
            self.runs[name].status = RunStatus.FAILED

    @rule(claim=claims)
    def lose(self, claim: Claim) -> None:
        held = self.held(claim)
        self.store.lose(claim, "its worker was lost")
        self.expect_loss(held)

    @rule(claim=consumes(claims))
    def release(self, claim: Claim) -> None:
        held = self.held(claim)
        self.store.release(claim, "stopped")
        for name in held:
            self.give_back(self.runs[name])

    @rule()
    def expire(self) -> None:
        before = self.store.last_event_id()
        self.store.lose_expired()
        moved = {
            event.payload["run_id"]
            for event in self.store.events_after(before)
            if event.kind == "run"
        }
        assert all(self.runs[name].status is RunStatus.RUNNING for name in moved)
        self.expect_loss(list(moved))

    def expect_loss(self, names: list[str]) -> None:
        for name in names:
            run = self.runs[name]
            run.losses += 1
            if run.losses > AT_ONCE.losses and not run.is_cancelling:
                run.status = RunStatus.FAILED
            else:
                self.give_back(run)

    def give_back(self, run: Expected) -> None:
        run.status = RunStatus.CANCELLED if run.is_cancelling else RunStatus.QUEUED

    @rule(data=st.data())
    def cancel(self, data: st.DataObject) -> None:
        if not self.runs:
            return
        name = data.draw(st.sampled_from(list(self.runs)))
        run = self.runs[name]
        try:
            self.store.move_run(name, "cancel")
        except ImpossibleMoveError:
            assert run.status.is_final
            assert run.status is not RunStatus.CANCELLED
            return
        if run.status in {RunStatus.QUEUED, RunStatus.PAUSED}:
            run.status = RunStatus.CANCELLED
        elif run.status is RunStatus.RUNNING:
            run.is_cancelling = True

    @rule(data=st.data(), how=st.sampled_from(["pause", "resume", "retry", "uncancel"]))
    def move(self, data: st.DataObject, how: Move) -> None:
        if not self.runs:
            return
        name = data.draw(st.sampled_from(list(self.runs)))
        run = self.runs[name]
        source, target, idle = {
            "pause": (RunStatus.QUEUED, RunStatus.PAUSED, {RunStatus.PAUSED}),
            "resume": (RunStatus.PAUSED, RunStatus.QUEUED, {RunStatus.QUEUED, RunStatus.RUNNING}),
            "retry": (RunStatus.FAILED, RunStatus.QUEUED, ACTIVE),
            "uncancel": (RunStatus.CANCELLED, RunStatus.QUEUED, ACTIVE),
        }[how]
        asked = partial(self.store.move_run, name, how)
        if run.status is source:
            assert asked().status is target
            run.status = target
            if how in {"retry", "uncancel"}:
                run.losses, run.is_cancelling = 0, False
        elif run.status in idle:
            assert asked().status is run.status
        else:
            with pytest.raises(ImpossibleMoveError):
                asked()

    def any_sweep(self, data: st.DataObject) -> tuple[str, dict[str, Expected]]:
        """A sweep and its runs."""
        sweep_id = data.draw(st.sampled_from(sorted({sweep_of(name) for name in self.runs})))
        return sweep_id, {n: run for n, run in self.runs.items() if sweep_of(n) == sweep_id}

    @precondition(lambda self: self.runs)
    @rule(data=st.data())
    def delete(self, data: st.DataObject) -> None:
        sweep_id, own = self.any_sweep(data)
        if any(run.status in ACTIVE for run in own.values()):
            with pytest.raises(ImpossibleMoveError):
                self.store.delete_sweep(sweep_id)
            return
        assert self.store.delete_sweep(sweep_id) == len(own)
        for name in own:
            del self.runs[name]

    @rule()
    def purge(self) -> None:
        """Throw a part of what was deleted away; the service may be killed before the next."""
        if gone := self.store.deleted_runs(1):
            self.store.purge_runs(gone)
        else:
            self.store.purge_sweep()

    @precondition(lambda self: self.runs)
    @rule(data=st.data())
    def extend(self, data: st.DataObject) -> None:
        """Give a sweep more timesteps."""
        sweep_id, own = self.any_sweep(data)
        [cell] = self.store.sweep_cells(sweep_id)
        seen, longer = self.store.sweep_request(sweep_id), cell.spec.timesteps + 800
        asked = partial(self.store.extend_sweep, sweep_id, seen, longer, lambda _: 1)
        if any(run.status is RunStatus.RUNNING for run in own.values()):
            with pytest.raises(ImpossibleMoveError):
                asked()
            return
        asked()
        for run in own.values():
            if run.status is RunStatus.SUCCEEDED:
                run.status, run.losses = RunStatus.QUEUED, 0

    @precondition(lambda self: self.runs)
    @rule(data=st.data())
    def add_seed(self, data: st.DataObject) -> None:
        sweep_id, own = self.any_sweep(data)
        seen, seed = self.store.sweep_request(sweep_id), len(own)
        self.store.add_seeds(sweep_id, seen, [seed], lambda _: 1)
        self.runs[f"{sweep_id}-{seed}"] = Expected()

    @invariant()
    def the_database_is_whole(self) -> None:
        assert [each for each in self.store.read(check) if each.faults] == []

    @rule()
    def restart(self) -> None:
        self.store.close()
        self.store = Store.open(self.url, AT_ONCE)

    @invariant()
    def store_says_what_the_model_says(self) -> None:
        for name, expected in self.runs.items():
            run = self.store.find_run(name)
            assert run is not None
            assert (run.status, run.attempt) == (expected.status, expected.attempt)
            assert len(self.store.attempts(name)) == expected.attempt
            points = [measurement.timestep for measurement in self.store.measurements(name)]
            assert points == sorted(expected.timesteps)

    @invariant()
    def events_tell_the_same(self) -> None:
        last = {
            event.payload["run_id"]: event.payload["status"]
            for event in self.store.events_after(0, limit=100_000)
            if event.kind == "run" and event.payload["run_id"] in self.runs
        }
        assert last == {
            name: run.status.value
            for name, run in self.runs.items()
            if name in last or run.attempt > 0 or run.status is not RunStatus.QUEUED
        }


def drive(fresh: Fresh, examples: int) -> None:
    class Machine(StoreMachine):
        def __init__(self) -> None:
            super().__init__(fresh())

    run_state_machine_as_test(
        Machine, settings=settings(max_examples=examples, stateful_step_count=20, deadline=None)
    )


def test_sqlite_in_any_order(fresh_sqlite: Fresh) -> None:
    drive(fresh_sqlite, examples=15)


def test_postgresql_in_any_order(fresh_postgresql: Fresh) -> None:
    drive(fresh_postgresql, examples=3)


@pytest.mark.slow
def test_in_any_order_at_length(fresh: Fresh) -> None:
    drive(fresh, examples=200)
