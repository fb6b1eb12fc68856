"""Workers as Ray actors.

A slot keeps one actor warm and gives it one piece of work after the other; when the actor dies it
makes another. Ray repeats nothing by itself (`max_restarts=0`, `max_task_retries=0`): the keeper of
the record decides what to repeat. Messages leave an actor as text, so that nothing of ours is
unpickled here.
"""

import itertools
import os
import queue
import socket
import threading
import time
import traceback
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import ray
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

from workers.driver.placement import Node
from workers.driver.terms import Terms
from workers.driver.worker_log import WorkerLog
from workers.messages.log_tail import log_tail
from workers.messages.report import Busy, Ended, Failed, Lost, News, Ready, Retired, to_line
from workers.messages.work import Work
from workers.training.execute import execute
from workers.training.narrator import Narrator

UNREAD_LIMIT = 2
"""Number of progresses that may wait for the driver before the actor's stream waits."""
IDLE_CHECK_SECONDS = 5.0
LONGEST_PAUSE_SECONDS = 30.0
EXIT_ABANDONED = 75
REPORTS_A_LOG = 2
"""Output is sent with every second report, since it is stored with every run of the cohort."""
WORKER_SECONDS = 3600.0
"""An older worker ends with its cohort and is replaced, which frees leaked memory."""

Send = Callable[[str], None]


class Worker:
    """The actor in a worker's process. Calls to `drop` arrive while `train` streams."""

    def __init__(self, name: str, log_path: str, checkpoints: str) -> None:
        """Send all output of the process to the log file, a crash's stack too."""
        self._name = name
        self._checkpoints = checkpoints
        self._log = WorkerLog(Path(log_path))
        self._log.take_output()
        self._cohort = ""
        self._dropped: set[int] = set()

    def describe(self) -> tuple[int, str]:
        """Return this process's id and host, which also shows that it is alive."""
        return os.getpid(), socket.gethostname()

    def train(self, document: dict[str, Any]) -> Iterator[str]:
        """Train what is assigned: lines of News, then of Ended or Failed."""
        work = Work.from_json(document)
        cohort = work.cohort
        self._cohort, self._dropped = cohort, set()
        self._log.begin()
        narrator = Narrator(work)
        try:
            told = execute(
                work.runs,
                self._checkpoints,
                lambda: self._dropped,
                _leave,
                file=work.file,
                measure_random_return=work.measure_random_return,
                report_seconds=work.report_seconds,
            )
            for progress in told:
                narrator.tell(progress)
                wait = 0.0 if progress.gone else REPORTS_A_LOG * work.report_seconds
                said = replace(progress, log_tail=self._log.news(wait))
                yield to_line(News(self._name, cohort, said))
        except Exception:
            yield to_line(Failed(self._name, cohort, traceback.format_exc(), self._log.tail()))
        else:
            yield to_line(Ended(self._name, cohort))

    def drop(self, cohort: str, seeds: Collection[int]) -> None:
        """Stop training these seeds; a call for an earlier cohort has no effect."""
        if cohort == self._cohort:
            self._dropped |= set(seeds)


def _leave() -> None:
    """End this process, since the driver has gone."""
    os._exit(EXIT_ABANDONED)


RemoteWorker: Any = ray.remote(Worker)


class ActorSlot:
    """A Slot of the pool: one actor at a time, on one node and a thread of its own."""

    def __init__(
        self,
        node: Node,
        names: "itertools.count[int]",
        terms: Terms,
        logs: Path,
        send: Send,
    ) -> None:
        """Start the thread."""
        self._terms = terms
        self._logs = logs
        self.node = node.name
        self.worker = ""
        self._names = names
        self._send = send
        self._work: queue.SimpleQueue[Work | None] = queue.SimpleQueue()  # None: retire
        self._actor: Any = None
        self._cohort = ""
        self._is_up = False
        self._is_closing = False
        self._idle_since: float | None = time.monotonic()
        threading.Thread(target=self._run, name="slot", daemon=True).start()

    @property
    def idle_seconds(self) -> float:
        """How long it has been idle, the start of its worker included."""
        since = self._idle_since
        return 0.0 if since is None else time.monotonic() - since

    def train(self, work: Work) -> None:
        """Give the worker a cohort."""
        self._idle_since = None
        self._work.put(work)

    def drop(self, seeds: Collection[int]) -> None:
        """Pass on which seeds to drop from the cohort in training."""
        self._actor.drop.remote(self._cohort, list(seeds))

    def kill(self) -> None:
        """End the worker's process."""
        if self._actor is not None:
            ray.kill(self._actor)

    def close(self) -> None:
        """Make no new actor after this one."""
        self._is_closing = True

    def retire(self) -> None:
        """End the worker, which is idle; a worker that has not started yet is given up."""
        self.close()
        self._work.put(None)
        if not self._is_up:
            self.kill()

    def _run(self) -> None:
        pause = 0.0
        while not self._is_closing:
            self.worker = f"worker-{next(self._names)}"
            self._work = queue.SimpleQueue()
            self._idle_since = time.monotonic()
            log_path = self._logs / f"{self.worker}.log"
            begun = time.monotonic()
            try:
                self._actor = self._make_actor(log_path)
                self._serve()
            except ray.exceptions.RayError as error:
                self._send(to_line(Lost(self.worker, _reason(error), log_tail(log_path))))
            self._is_up = False
            time.sleep(pause)
            lived_long = time.monotonic() - begun > LONGEST_PAUSE_SECONDS
            pause = 0.0 if lived_long else min(2 * pause + 1, LONGEST_PAUSE_SECONDS)

    def _make_actor(self, log_path: Path) -> Any:
        """Begin to make an actor on the node; if the node is dead, the first call raises."""
        actor_class = RemoteWorker.options(
            num_cpus=1,
            memory=self._terms.worker_bytes or None,
            max_restarts=0,
            max_task_retries=0,
            max_concurrency=2,
            scheduling_strategy=NodeAffinitySchedulingStrategy(self.node, soft=False),
        )
        return actor_class.remote(self.worker, str(log_path), self._terms.checkpoints)

    def _serve(self) -> None:
        """Do work until the worker is retired, too old, or lost; the latter raises Ray's error."""
        begun = time.monotonic()
        pid, host = ray.get(self._actor.describe.remote())
        self._is_up = True
        self._send(to_line(Ready(self.worker, pid, host)))
        while time.monotonic() - begun < WORKER_SECONDS:
            try:
                work = self._work.get(timeout=IDLE_CHECK_SECONDS)
            except queue.Empty:
                ray.get(self._actor.describe.remote())
                continue
            if work is None:
                break
            self._train(work)
            self._idle_since = time.monotonic()
        self._send(to_line(Retired(self.worker)))
        self.kill()

    def _train(self, work: Work) -> None:
        self._idle_since = None
        self._cohort = work.cohort
        self._send(to_line(Busy(self.worker, work)))
        stream = self._actor.train.options(
            num_returns="streaming", _generator_backpressure_num_objects=UNREAD_LIMIT
        ).remote(work.to_json())
        for line in stream:
            self._send(ray.get(line))


def _reason(error: Exception) -> str:
    """Return the first line of Ray's message on a loss, which says what was lost and how."""
    if isinstance(error, ray.exceptions.OutOfMemoryError):
        return "its worker was ended because the machine ran out of memory"
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    details = [line for line in lines if line.startswith(("The actor is dead", "Worker exit"))]
    return "its worker was lost: " + (details or lines or [type(error).__name__])[0]
