"""A seeded world around the scheduler, in which everything goes wrong that can.

The workers are pretended, the clock is a number, the store is real; the seed decides what happens
in which order. One step is one thing that happens: a worker trains a cycle, a report arrives (late,
or twice), a command is carried out (or refused, or its answer is lost), a user cancels, pauses,
resumes or retries, a worker crashes or freezes or vanishes, the service is killed or frozen, the
cluster goes. After each step the promises are checked that the step could have broken.
"""

import random
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from service.model.inquiry.search import Search
from service.queue.batch import next_together
from service.queue.dispatch_state import DispatchTimes, State
from service.queue.messages import (
    AskCancelling,
    AskWaiting,
    Cancelling,
    ClaimCohort,
    Claimed,
    Command,
    Demand,
    Drop,
    Fail,
    Kill,
    Lose,
    LoseExpired,
    PoolLost,
    QueueEvent,
    Record,
    Recorded,
    Release,
    StartPool,
    Tick,
    Train,
    Waiting,
)
from service.queue.question_rounds import Batch, next_batch
from service.queue.scheduler import step
from service.queue.search_rounds import Rung, next_rung
from service.store.claiming.retry import RetryPolicy
from service.store.store import Store
from tests.service.fake_pool import CYCLE, FakeWorker
from tests.service.memory_database import in_memory
from tests.service.promises import Promises
from tests.service.simulated_users import SimulatedUsers
from workers.messages.progress import Progress
from workers.messages.random_return import RandomReturn
from workers.messages.report import (
    Busy,
    Capacity,
    Ended,
    Failed,
    Lost,
    News,
    Ready,
    Report,
    Retired,
)

WORKERS = 3
TIMESTEPS = 4 * CYCLE
DIVERGING, RAISING = {3}, {5}
TIMES = DispatchTimes()
RETRY = RetryPolicy(losses=6, first_wait_seconds=0.5, longest_wait_seconds=4.0)
LONGEST_STEP = 1.0
"""Seconds that pass at most from one tick to the next while nothing is frozen."""


QUESTIONS = (AskCancelling, AskWaiting, Demand, Train, Drop, Kill, StartPool)
"""Commands that change nothing in the store."""


@dataclass
class SimulatedWorker:
    """A worker, and its reports that have not arrived yet."""

    worker: FakeWorker
    reports: deque[Report] = field(default_factory=deque)
    is_gone: bool = False
    is_ended: bool = False  # gone, and the pool knows
    standing: Report | None = None  # what it does, as far as its reports have arrived

    def hear(self, report: Report) -> None:
        """Note what it does."""
        if isinstance(report, Ready | Busy):
            self.standing = report
        elif isinstance(report, Ended | Failed):
            self.standing = Ready(self.worker.name, 1, "here")

    @property
    def is_held_up(self) -> bool:
        """Whether its reports have to wait: it is frozen, and so is what it has said last."""
        return self.worker.is_frozen and not self.is_gone

    @property
    def is_training(self) -> bool:
        """Whether it gets on."""
        return bool(self.worker.specs) and not self.worker.is_frozen and not self.is_gone


class Simulation:
    """One world; `run(steps)` makes so many things happen, then heals it and waits for the end.

    What may happen returns whether it did.
    """

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)  # noqa: S311
        self.now = 1000.0
        self.engine = in_memory(lambda: self.now)
        self.store = Store(self.engine, self.engine, RETRY)
        self.store.record_random_return(RandomReturn("Pendulum", 1, -1.0, -2.0, 0.0, 1000))
        self.state = State()
        self.commands: deque[Command] = deque()
        self.workers: dict[str, SimulatedWorker] = {}
        self.names = 0
        self.cluster_is_gone = False
        self.refusals: deque[str] = deque()
        self.promises = Promises(self.store, self.engine, lambda: self.now, TIMESTEPS, DIVERGING)
        self.models = self.promises.models
        self.steps = 0
        self.excused_until = 0.0
        self.in_hand: list[tuple[SimulatedWorker, Report]] = []
        self.delivered: deque[Report] = deque(maxlen=50)
        self.story: deque[str] = deque(maxlen=40)
        self.looks: deque[tuple[str, str | None, Batch]] = deque(maxlen=5)
        self.climbs: deque[tuple[str, str | None, Rung]] = deque(maxlen=5)
        self.users = SimulatedUsers(self.promises, self.random, RAISING, self.tell)

    def close(self) -> None:
        """Let go of the database."""
        self.store.close()

    def run(self, steps: int) -> None:
        """Make things happen, then let no more go wrong and see all work done."""
        happenings: list[tuple[Callable[[], bool], float]] = [
            (self.train, 40),
            (self.deliver, 40),
            (self.carry_out, 80),
            (self.tick, 10),
            (self.users.submit, 4),
            (self.users.ask_question, 1),
            (self.look, 4),
            (self.users.search, 0.7),
            (self.climb, 4),
            (self.beat, 4),
            (self.users.move_run, 2),
            (self.users.cancel_sweep, 0.4),
            (self.users.pause_sweep, 0.5),
            (self.users.resume_sweep, 1),
            (self.users.retry_sweep, 0.6),
            (self.users.delete_sweep, 0.5),
            (self.users.purge, 1),
            (self.crash, 0.8),
            (self.vanish, 0.3),
            (self.retire, 0.5),
            (self.resize, 0.5),
            (self.freeze, 0.5),
            (self.thaw, 1),
            (self.repeat, 2),
            (self.reap, 1),
            (self.refuse, 0.5),
            (self.kill_service, 0.3),
            (self.freeze_service, 0.5),
            (self.lose_cluster, 0.1),
            (self.restore_cluster, 0.5),
        ]
        acts, weights = zip(*happenings, strict=True)
        while self.steps < steps:
            [act] = self.random.choices(acts, weights)
            self.steps += act()
        self.heal()

    def heal(self) -> None:
        """Every fault ceases; then all that was asked for is done, soon."""
        self.refusals.clear()
        self.restore_cluster()
        for simulated in self.workers.values():
            simulated.worker.is_frozen = simulated.worker.is_deaf = False
        self.users.resume_all()
        deadline = self.now + 400.0
        while self.promises.active or self.store.waiting_questions():
            assert self.now < deadline, f"not done: {self.models}"
            self.steps += 1
            for name in list(self.workers):
                self.train(name)
                self.finish_commands()
                while self.deliver(name):
                    self.finish_commands()
            self.tick()
            self.finish_commands()
            self.look()
            self.climb()
        self.promises.check_counts()
        self.promises.check_questions()
        self.promises.check_searches()
        for name in self.models:
            self.promises.check_curve(name)

    def finish_commands(self) -> None:
        """Carry out all that was commanded."""
        while self.commands:
            self.carry_out()

    # ---- the service

    def tell(self, happened: object) -> None:
        """Note what happened, for whoever reads of a failure."""
        self.story.append(f"{self.now:.2f} {happened}"[:300])

    def give(self, *happenings: QueueEvent) -> None:
        """Have the scheduler take events into account."""
        commands: list[Command] = []
        for happening in happenings:
            self.tell(happening)
            self.state, more = step(self.state, happening, self.now, TIMES)
            commands += more
        self.commands.extendleft(reversed(commands))

    def tick(self) -> bool:
        """Let some time pass; the thread has its round, unless the store holds it up."""
        if self.commands and not self.refusals:
            return False
        self.now += self.random.uniform(0.01, LONGEST_STEP)
        if self.commands:
            self.excuse()  # held up by the store, which cannot end leases either
            return True
        self.give(Tick())
        self.check_leases()
        return True

    def carry_out(self) -> bool:
        """Carry out what is next, if the store lets it happen; the answers are the next events."""
        if not self.commands:
            return False
        together = next_together(self.commands)
        fault = self.refusals.popleft() if self.refusals else ""
        if fault == "refused":
            return True
        if isinstance(together[0], QUESTIONS):
            answers = self.do(together)
        else:
            with self.promises.touching(set().union(*map(self.touched_by, together))):
                answers = self.do(together)
        for command in together:
            if isinstance(command, Record):
                self.check_renewed(command)
        if fault == "answer lost":  # done, but it will be done again
            return True
        for command in together:
            self.tell(command)
            self.commands.popleft()
        self.give(*answers)
        return True

    def touched_by(self, command: Command) -> set[str]:
        """The runs that a command may change."""
        match command:
            case Record(claim) | Lose(claim) | Release(claim) | Fail(claim):
                return self.promises.held(claim)
            case LoseExpired():
                return self.promises.expired()
            case ClaimCohort():
                return self.promises.waiting()
            case _:
                return set()

    def do(self, together: Sequence[Command]) -> list[QueueEvent]:
        """Do what `service/queue/dispatch.py` does."""
        records = [command for command in together if isinstance(command, Record)]
        if records:
            said = [(record.claim, record.news.progress) for record in records]
            held = map(frozenset, self.store.record_all(said))
            return [Recorded(r.news, runs) for r, runs in zip(records, held, strict=True)]
        claims = [command for command in together if isinstance(command, ClaimCohort)]
        if claims:
            asked = [(each.worker, each.limit) for each in claims]
            found = self.store.claim_all(asked, claims[0].lease_seconds)
            return [Claimed(each.worker, claim) for each, claim in zip(claims, found, strict=True)]
        answer = self.do_one(together[0])
        return [] if answer is None else [answer]

    def do_one(self, command: Command) -> QueueEvent | None:
        match command:
            case Lose(claim, reason, log_tail):
                self.store.lose(claim, reason, log_tail)
            case Release(claim, reason):
                self.store.release(claim, reason)
            case Fail(claim, error, log_tail):
                self.store.fail(claim, error, log_tail)
            case LoseExpired():
                self.store.lose_expired()
            case AskCancelling():
                return Cancelling(frozenset(self.store.cancelling_runs()))
            case AskWaiting(limit):
                return Waiting(tuple(self.store.waiting_cells(limit)), limit, frozenset())
            case Train(worker, work):
                simulated = self.workers.get(worker)
                if simulated is not None and not simulated.is_gone:
                    simulated.reports.append(simulated.worker.begin(work))
            case Drop(worker, seeds):
                if worker in self.workers:
                    self.workers[worker].worker.drop(seeds)
            case Kill(worker):
                self.end(worker)
            case StartPool():
                return self.start_pool()
        return None

    def look(self) -> bool:
        """Look at a question whose batch has ended; killed at any moment, it looks again.

        It is killed before it writes, or after: then it writes the same once more. Or it was held
        up, and writes later.
        """
        waiting = [each for each in self.store.waiting_questions() if not self.search_of(each)]
        if waiting:
            sweep_id = self.random.choice(waiting)
            seen = self.store.sweep_version(sweep_id)
            self.looks.append((sweep_id, seen, self.next_batch(sweep_id)))
        if not self.looks or self.random.random() < 0.3:
            return bool(waiting)
        sweep_id, seen, batch = self.random.choice(self.looks)
        is_current = sweep_id in waiting and self.store.sweep_version(sweep_id) == seen
        assert not is_current or self.next_batch(sweep_id) == batch
        have = {(run.spec.environment, run.entry, run.spec.seed)
                for run in self.store.list_runs(sweep_id, limit=1000)}  # fmt: skip
        missing = {(*cell, seed) for cell, seeds in batch.items() for seed in seeds} - have
        added = self.store.go_on_asking(sweep_id, seen, batch)
        assert added == (len(missing) if is_current else 0)
        assert self.store.find_sweep(sweep_id) is None or self.promises.add(sweep_id) == added
        self.tell(f"sweep {sweep_id} was at {seen}: {added} runs were added")
        return True

    def climb(self) -> bool:
        """As `look`, at a search whose rung has ended."""
        waiting = [each for each in self.store.waiting_questions() if self.search_of(each)]
        if waiting:
            sweep_id = self.random.choice(waiting)
            seen = self.store.sweep_version(sweep_id)
            self.climbs.append((sweep_id, seen, self.next_rung(sweep_id)))
        if not self.climbs or self.random.random() < 0.3:
            return bool(waiting)
        sweep_id, seen, rung = self.random.choice(self.climbs)
        is_current = sweep_id in waiting and self.store.sweep_version(sweep_id) == seen
        assert not is_current or self.next_rung(sweep_id) == rung
        short = {
            run.id
            for run in self.store.list_runs(sweep_id, limit=1000)
            if run.spec.timesteps < rung.get((run.spec.environment, run.entry), 0)
        }
        with self.promises.touching(short if is_current else set(), asked="climb"):
            longer = self.store.go_on_searching(sweep_id, seen, rung)
        assert longer == (len(short) if is_current else 0)
        assert self.store.find_sweep(sweep_id) is None or self.promises.climb(sweep_id) == longer
        self.tell(f"search {sweep_id} was at {seen}: {longer} runs go on")
        return True

    def search_of(self, sweep_id: str) -> Search | None:
        """What a sweep searches."""
        return self.store.get_sweep(sweep_id).search

    def next_batch(self, sweep_id: str) -> Batch:
        """What a question that is there would be given."""
        return next_batch(self.store, self.store.get_sweep(sweep_id))

    def next_rung(self, sweep_id: str) -> Rung:
        """What a search that is there would be given."""
        sweep = self.store.get_sweep(sweep_id)
        assert sweep.search is not None
        return next_rung(self.store, sweep, sweep.search)

    def start_pool(self) -> PoolLost | None:
        if self.cluster_is_gone:
            return PoolLost("nothing answers", "12:00:00")
        if self.workers:  # it outlived the service; each worker says what it does
            for simulated in self.workers.values():
                if simulated.standing is not None:
                    simulated.reports.appendleft(simulated.standing)
            return None
        for _ in range(WORKERS):
            self.make_worker()
        return None

    def kill_service(self) -> bool:
        """Forget everything but the store; the workers go with it, or are found again."""
        self.tell("the service is killed")
        if self.commands:
            for simulated, report in self.in_hand:
                simulated.reports.appendleft(report)  # it will be told again
            self.in_hand = []
        self.acknowledge()
        self.state, self.commands = State(), deque()
        if self.random.random() < 0.5:
            self.workers.clear()
        self.now += self.random.uniform(0.5, 60.0)
        self.excuse()
        if self.random.random() < 0.5:
            self.reap()
        return True

    def freeze_service(self) -> bool:
        """Neither the service nor anything that it would have heard gets on; it wakes first."""
        self.now += self.random.uniform(1.0, 300.0)
        self.tell("the service was frozen")
        self.excuse()
        if self.random.random() < 0.5:
            self.reap()
        if self.random.random() < 0.5:
            self.freeze()
        return True

    def refuse(self) -> bool:
        """The database takes nothing, or takes it and does not say so."""
        fault = self.random.choice(["refused", "answer lost"])
        self.refusals.extend([fault] * self.random.randint(1, 5))
        return True

    def excuse(self) -> None:
        """Leases could not be renewed until now, so none is looked at for the time of one."""
        self.excused_until = self.now + TIMES.lease + 2 * LONGEST_STEP

    # ---- the workers

    def make_worker(self) -> None:
        """Bring up another worker."""
        self.names += 1
        name = f"worker-{self.names}"
        self.workers[name] = SimulatedWorker(FakeWorker(name), deque([Ready(name, 1, "here")]))

    def any_worker(self) -> str:
        return self.random.choice(list(self.workers)) if self.workers else ""

    def train(self, name: str | None = None) -> bool:
        """Have a worker train a cycle."""
        simulated = self.workers.get(name or self.any_worker())
        if simulated is None or not simulated.is_training:
            return False
        simulated.reports += simulated.worker.cycle(DIVERGING, RAISING)
        return True

    def beat(self) -> bool:
        """Have a worker say that it lives."""
        simulated = self.workers.get(self.any_worker())
        if simulated is None or not simulated.is_training:
            return False
        worker = simulated.worker
        simulated.reports.append(News(worker.name, worker.cohort, Progress(worker.timestep)))
        return True

    def deliver(self, *names: str) -> bool:
        """Have workers' next reports arrive at once, where the thread has time for them."""
        if self.commands or not self.state.pool_is_up:
            return False
        chosen = names or self.random.choices(list(self.workers), k=WORKERS) if self.workers else ()
        speaking = [self.workers[name] for name in dict.fromkeys(chosen) if name in self.workers]
        speaking = [each for each in speaking if each.reports and not each.is_held_up]
        if not speaking:
            return False
        self.acknowledge()
        self.in_hand = [(each, each.reports.popleft()) for each in speaking]
        self.give(*(report for _, report in self.in_hand))
        return True

    def acknowledge(self) -> None:
        """All that the last reports led to is in the store: they need not be told again."""
        for simulated, report in self.in_hand:
            self.delivered.append(report)
            simulated.hear(report)
            if isinstance(report, Lost | Retired):
                del self.workers[simulated.worker.name]
        self.in_hand = []

    def repeat(self) -> bool:
        """Have a report arrive once more, however long ago it did."""
        if self.commands or not self.state.pool_is_up or not self.delivered:
            return False
        self.give(self.random.choice(self.delivered))
        return True

    def crash(self) -> bool:
        """End a worker's process; what it had said may yet arrive."""
        return self.end(self.any_worker())

    def vanish(self) -> bool:
        """As `crash`, and nobody notices."""
        simulated = self.workers.get(self.any_worker())
        if simulated is None or simulated.is_gone:
            return False
        simulated.is_gone = True
        return True

    def end(self, name: str) -> bool:
        simulated = self.workers.get(name)
        if simulated is None or simulated.is_ended:
            return False
        simulated.is_gone = simulated.is_ended = True
        simulated.reports.append(Lost(name, "its worker was lost: SIGKILL", "last words"))
        self.make_worker()
        return True

    def retire(self) -> bool:
        """End a worker that does nothing; the service may give it work before it hears of that."""
        simulated = self.workers.get(self.any_worker())
        if simulated is None or simulated.is_gone or simulated.worker.specs:
            return False
        simulated.is_gone = simulated.is_ended = True
        simulated.reports.append(Retired(simulated.worker.name))
        self.make_worker()
        return True

    def resize(self) -> bool:
        """Have the cluster say what it has room for."""
        if self.commands or not self.state.pool_is_up:
            return False
        self.give(Capacity(self.random.randint(0, 2 * WORKERS), slots=len(self.workers)))
        return True

    def freeze(self) -> bool:
        """Stop a worker, or make it deaf to what it is told."""
        simulated = self.workers.get(self.any_worker())
        if simulated is None:
            return False
        if self.random.random() < 0.5:
            simulated.worker.is_frozen = True
        else:
            simulated.worker.is_deaf = True
        return True

    def thaw(self) -> bool:
        """Have a worker go on."""
        simulated = self.workers.get(self.any_worker())
        if simulated is None or not simulated.worker.is_frozen:
            return False
        simulated.worker.is_frozen = False
        return True

    def lose_cluster(self) -> bool:
        """Every worker goes at once, and no other comes until the cluster is restored."""
        if self.commands or not self.state.pool_is_up:
            return False
        self.cluster_is_gone = True
        self.in_hand = []
        self.workers.clear()
        self.give(PoolLost("its head is gone", "12:00:00"))
        return True

    def restore_cluster(self) -> bool:
        """Let the cluster be had again."""
        was_gone, self.cluster_is_gone = self.cluster_is_gone, False
        return was_gone

    def reap(self) -> bool:
        """Another service on the same database ends what leases have run out."""
        self.tell("another service looks for expired leases")
        with self.promises.touching(self.promises.expired()):
            self.store.lose_expired()
        return True

    # ---- the promises

    def check_leases(self) -> None:
        """No run is running for long without a live lease."""
        if self.now > self.excused_until:
            for name, until in self.promises.leases().items():
                overdue = self.now - until
                assert overdue <= TIMES.expiry + 2 * LONGEST_STEP, f"{name}: ended {overdue} s ago"

    def check_renewed(self, record: Record) -> None:
        """What a worker says renews the leases of those of its runs that go on."""
        for name in self.promises.held(record.claim):
            assert self.promises.leases()[name] == self.now + record.claim.lease_seconds
