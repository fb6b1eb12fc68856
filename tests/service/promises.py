"""What a store promises, watched from outside: each change says beforehand which runs it may touch.

The model of each run is kept from the store's own events; the curves, the counts and the leases
are looked at in the store.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal

from sqlalchemy import Engine

from service.model.claim import Claim
from service.model.event import Event
from service.model.inquiry.question import Question
from service.model.move import Move
from service.model.run import FINAL, RunStatus
from service.model.run_name import RunName
from service.queue.question_rounds import next_batch
from service.queue.search_rounds import next_rung
from service.store.store import Store
from tests.service.fake_pool import CYCLE, measurement_of

Asked = Move | Literal["climb"]
AGAIN = {
    ("retry", RunStatus.FAILED),
    ("uncancel", RunStatus.CANCELLED),
    ("climb", RunStatus.SUCCEEDED),
}
"""What users may have begun again of what has ended, and what goes on to the next rung."""


def runs_of(event: Event) -> list[str]:
    """The runs whose status an event tells of, or their measurements."""
    if event.kind == "run":
        return [event.payload["run_id"]]
    return list(event.payload["run_ids"]) if event.kind == "measurements" else []


@dataclass
class Model:
    """What must be so of a run."""

    seed: int
    timesteps: int
    status: str = RunStatus.QUEUED
    attempt: int = 0
    measured: set[int] = field(default_factory=set)


class Promises:
    """Of one store, in which every run has so many timesteps and `diverging` seeds diverge."""

    def __init__(
        self,
        store: Store,
        engine: Engine,
        clock: Callable[[], float],
        timesteps: int,
        diverging: Collection[int],
    ) -> None:
        self.store = store
        self.engine = engine
        self.clock = clock
        self.timesteps = timesteps
        self.diverging = diverging
        self.models: dict[str, Model] = {}
        self.paused: set[str] = set()  # sweeps
        self.cancelled: set[str] = set()
        self.seen_event = 0

    @property
    def active(self) -> int:
        """How many runs have not ended."""
        return sum(model.status not in FINAL for model in self.models.values())

    def add(self, sweep_id: str) -> int:
        """Take in the runs that a sweep has got; return how many. No cell has a seed twice."""
        listed = self.store.list_runs(sweep_id, limit=1000)
        cells = [(run.spec.environment, run.entry, run.spec.seed) for run in listed]
        assert len(set(cells)) == len(cells)
        fresh = [run for run in listed if run.id not in self.models]
        expected = RunStatus.PAUSED if sweep_id in self.paused else RunStatus.QUEUED
        assert all(run.status == expected for run in fresh)
        self.models |= {
            run.id: Model(run.spec.seed, run.spec.timesteps, run.status) for run in fresh
        }
        return len(fresh)

    def climb(self, sweep_id: str) -> int:
        """Take in the timesteps that runs of a sweep have got; return how many. None has fewer."""
        longer = 0
        for run in self.store.list_runs(sweep_id, limit=1000):
            model = self.models[run.id]
            assert run.spec.timesteps >= model.timesteps
            longer += run.spec.timesteps > model.timesteps
            model.timesteps = run.spec.timesteps
        return longer

    # ---- which runs a change may touch

    def held(self, claim: Claim) -> set[str]:
        """The runs of a claim that are its own now."""
        return {
            run.run_id
            for run in claim.runs
            if (model := self.models.get(run.run_id)) is not None
            and model.status == RunStatus.RUNNING
            and model.attempt == run.attempt
        }

    def waiting(self) -> set[str]:
        """The runs that may be claimed."""
        queued = {name for name, model in self.models.items() if model.status == RunStatus.QUEUED}
        return {n for n in queued if sweep_of(n) not in self.paused | self.cancelled}

    def expired(self) -> set[str]:
        """The runs whose leases have ended."""
        return {name for name, until in self.leases().items() if until < self.clock()}

    def of(self, sweep_id: str) -> set[str]:
        """The runs of a sweep."""
        return {name for name in self.models if sweep_of(name) == sweep_id}

    @contextmanager
    def touching(self, runs: Collection[str], *, asked: Asked | None = None) -> Iterator[None]:
        """Change the store: events are of these runs alone, and the others keep their leases."""
        before = self.leases()
        yield
        for event in self.store.events_after(self.seen_event):
            self.seen_event = event.id
            for name in runs_of(event):
                assert name in runs, f"{name} was changed by what may not: {event.payload}"
                if event.kind == "run":
                    self._check_move(name, event.payload, asked)
                else:
                    self._check_measured(name, event.payload)
        after = self.leases()
        for name in before.keys() - set(runs):
            assert after.get(name) == before[name], f"the lease of {name} was changed"

    def _check_move(self, name: str, payload: Mapping[str, Any], asked: Asked | None) -> None:
        """Final states never change, and an attempt is opened by a claim alone.

        An event that finds a run running tells more of its attempt: where it was taken up.
        """
        model, status = self.models[name], str(payload["status"])
        may_change = model.status not in FINAL or (asked, model.status) in AGAIN
        assert may_change, f"{name} was {model.status} and became {status}"
        begins = status == RunStatus.RUNNING != model.status
        assert payload["attempt"] == model.attempt + begins
        assert not begins or name in self.waiting(), f"{name} was {model.status} and was begun"
        model.status, model.attempt = status, model.attempt + begins
        if status in FINAL:
            self.check_curve(name)

    def _check_measured(self, name: str, payload: Mapping[str, Any]) -> None:
        model = self.models[name]
        fresh = set(range(payload["from"], payload["to"] + 1, CYCLE))
        assert not fresh & model.measured, f"{name} was measured twice"
        model.measured |= fresh

    # ---- what must be so at any time

    def leases(self) -> dict[str, float]:
        """Until when each running run is its worker's."""
        query = """SELECT sweeps.id || '-' || ordinal, lease_until FROM runs
                   JOIN sweeps ON sweeps.number = sweep_number WHERE runs.status = 'running'"""
        with self.engine.connect() as connection:
            return {row[0]: row[1] for row in connection.exec_driver_sql(query)}

    def check_curve(self, name: str) -> None:
        """A curve is the undisturbed one: whole where its run finished, else its beginning."""
        model = self.models[name]
        points = self.store.measurements(name)
        steps = [CYCLE * (index + 1) for index in range(len(points))]
        assert points == [measurement_of(model.seed, timestep) for timestep in steps]
        if model.status == RunStatus.SUCCEEDED:
            assert len(points) == model.timesteps // CYCLE
        if model.status == RunStatus.DIVERGED:
            assert model.seed in self.diverging
            assert len(points) == 1

    def check_counts(self) -> None:
        """The counts of each sweep are those of its runs."""
        for sweep in self.store.list_sweeps(limit=10_000):
            statuses = [self.models[name].status for name in self.of(sweep.id)]
            for status in RunStatus:
                assert getattr(sweep.runs, status.value) == statuses.count(status)

    def check_questions(self) -> None:
        """A question that was not cancelled is settled, with whole batches of its seeds alone."""
        for sweep in self.store.list_sweeps(limit=10_000):
            question = Question.of(sweep.request)
            if question is None:
                continue
            assert not sweep.is_asking
            seeds: dict[int, list[int]] = {}
            for run in self.store.list_runs(sweep.id, limit=1000):
                seeds.setdefault(run.entry, []).append(run.spec.seed)
            assert seeds[0] == seeds[1]
            looks = range(1, question.looks + 1)
            assert tuple(seeds[0]) in [question.seeds(look) for look in looks]
            assert next_batch(self.store, sweep) == {} or sweep.id in self.cancelled

    def check_searches(self) -> None:
        """A search that was not cancelled is settled: no entry lacks a rung that it is to climb."""
        for sweep in self.store.list_sweeps(limit=10_000):
            if sweep.search is None:
                continue
            assert not sweep.is_asking
            has: dict[tuple[str, int], set[int]] = {}
            for run in self.store.list_runs(sweep.id, limit=1000):
                has.setdefault((run.spec.environment, run.entry), set()).add(run.spec.timesteps)
            lengths = {rung.timesteps for rung in sweep.search.rungs["Pendulum"]}
            assert all(len(each) == 1 and each <= lengths for each in has.values())
            for cell, timesteps in next_rung(self.store, sweep, sweep.search).items():
                assert has[cell] == {timesteps} or sweep.id in self.cancelled


def sweep_of(run_id: str) -> str:
    """The sweep of a run."""
    return RunName.parse(run_id).sweep_id
