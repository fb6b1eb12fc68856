"""Workers as Ray actors; the only file that knows Ray.

A slot keeps one actor warm and gives it one piece of work after the other; when the actor dies it
makes another. Ray repeats nothing by itself (`max_restarts=0`, `max_task_retries=0`): what is to
be done again is decided by the one who keeps the record. Messages leave an actor as text, so that
nothing of ours is unpickled here.
"""

import faulthandler
import itertools
import json
import logging
import os
import queue
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import ray

from workers.execute import execute
from workers.log_tail import log_tail
from workers.outbox import Outbox
from workers.report import Busy, Ended, Failed, Lost, News, Ready, to_line
from workers.work import Work

OBJECT_STORE_BYTES = 80 * 2**20  # nearly Ray's least; progress is small and never stored
UNREAD_LIMIT = 2
"""Progresses that may wait for the driver; then the actor's stream waits."""
IDLE_CHECK_SECONDS = 5.0
NODE_CHECK_SECONDS = 2.0
LONGEST_PAUSE_SECONDS = 30.0
EXIT_ABANDONED = 75
JOIN_SECONDS = 20.0
OUTAGE_SECONDS = 900.0
"""How long workers train on while no service is there; then their checkpoints have to do."""
IDLE_OUTAGE_SECONDS = 30.0
START_SECONDS = 90.0  # on a busy machine; alone it takes 5 to 8

Send = Callable[[str], None]


class Worker:
    """What runs in a worker's process. Calls to `drop` arrive while `train` streams."""

    def __init__(self, name: str, log_path: str, checkpoints: str) -> None:
        """Send all output of the process to the log file, a crash's stack too."""
        self._name = name
        self._checkpoints = checkpoints
        self._log_path = Path(log_path)
        self._cohort = ""
        self._dropped: set[int] = set()
        self._log_path.parent.mkdir(parents=True, exist_ok=True)
        log = os.open(self._log_path, os.O_CREAT | os.O_WRONLY | os.O_TRUNC | os.O_APPEND, 0o600)
        os.dup2(log, 1)
        os.dup2(log, 2)
        os.close(log)
        faulthandler.enable(sys.__stderr__ or 2)

    def describe(self) -> tuple[int, str]:
        """Return this process's id and host; also how one sees that it lives."""
        return os.getpid(), socket.gethostname()

    def train(self, document: dict[str, Any]) -> Iterator[str]:
        """Train what is assigned: lines of News, then of Ended or Failed."""
        work = Work.from_json(document)
        cohort = work.cohort
        self._cohort, self._dropped = cohort, set()
        os.truncate(self._log_path, 0)
        try:
            told = execute(
                work.runs,
                self._checkpoints,
                lambda: self._dropped,
                _leave,
                measure_random_return=work.measure_random_return,
                report_seconds=work.report_seconds,
            )
            for progress in told:
                yield to_line(News(self._name, cohort, progress))
        except Exception:
            sys.stdout.flush()
            error, tail = traceback.format_exc(), log_tail(self._log_path)
            yield to_line(Failed(self._name, cohort, error, tail))
        else:
            yield to_line(Ended(self._name, cohort))

    def drop(self, cohort: str, seeds: Collection[int]) -> None:
        """Train these seeds no further; a word about an earlier cohort comes too late."""
        if cohort == self._cohort:
            self._dropped |= set(seeds)


def _leave() -> None:
    """End this process: nobody listens any more."""
    os._exit(EXIT_ABANDONED)


_actor_class: Any = ray.remote(Worker)
RemoteWorker = _actor_class.options(
    num_cpus=1, max_restarts=0, max_task_retries=0, max_concurrency=2
)


class Slot:
    """One worker at a time, on a thread of its own."""

    def __init__(
        self, names: "itertools.count[int]", logs: Path, checkpoints: str, send: Send
    ) -> None:
        """Start the thread."""
        self._names = names
        self._checkpoints = checkpoints
        self._logs = logs
        self._send = send
        self._work: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._actor: Any = None
        self._cohort = ""
        self._is_closing = False
        self.worker = ""
        threading.Thread(target=self._run, name="slot", daemon=True).start()

    def train(self, command: dict[str, Any]) -> None:
        """Give the worker a cohort."""
        self._work.put(command)

    def drop(self, seeds: Collection[int]) -> None:
        """Pass on which seeds to drop from the cohort in training."""
        self._actor.drop.remote(self._cohort, list(seeds))

    def kill(self) -> None:
        """End the worker's process."""
        ray.kill(self._actor)

    def close(self) -> None:
        """Make no other actor after this one."""
        self._is_closing = True

    def _run(self) -> None:
        pause = 0.0
        while not self._is_closing:
            self.worker = f"worker-{next(self._names)}"
            self._work = queue.SimpleQueue()
            log_path = self._logs / f"{self.worker}.log"
            begun = time.monotonic()
            try:
                self._actor = RemoteWorker.remote(self.worker, str(log_path), self._checkpoints)
                self._serve()
            except ray.exceptions.RayError as error:
                self._send(to_line(Lost(self.worker, _reason(error), log_tail(log_path))))
            time.sleep(pause)
            lived_long = time.monotonic() - begun > LONGEST_PAUSE_SECONDS
            pause = 0.0 if lived_long else min(2 * pause + 1, LONGEST_PAUSE_SECONDS)

    def _serve(self) -> None:
        """Do work until the actor is lost. Raises ray's error then."""
        pid, host = ray.get(self._actor.describe.remote())
        self._send(to_line(Ready(self.worker, pid, host)))
        while True:
            try:
                command = self._work.get(timeout=IDLE_CHECK_SECONDS)
            except queue.Empty:
                ray.get(self._actor.describe.remote())
                continue
            work = command["work"]
            self._cohort = work["cohort"]
            self._send(to_line(Busy(self.worker, self._cohort, work["note"])))
            stream = self._actor.train.options(
                num_returns="streaming", _generator_backpressure_num_objects=UNREAD_LIMIT
            ).remote(work)
            for line in stream:
                self._send(ray.get(line))


def _reason(error: Exception) -> str:
    """Return Ray's first line about a loss, which says what was lost and how."""
    if isinstance(error, ray.exceptions.OutOfMemoryError):
        return "its worker was ended because the machine ran out of memory"
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    details = [line for line in lines if line.startswith(("The actor is dead", "Worker exit"))]
    return "its worker was lost: " + (details or lines or [type(error).__name__])[0]


class ActorPool:
    """All slots; obeys one service after the other, until one closes the pool or none comes."""

    def __init__(self, outbox: Outbox, slots: int, logs: Path, checkpoints: str) -> None:
        """Start the slots."""
        self._outbox = outbox
        self._is_closed = False
        names = itertools.count(1)
        self._slots = [Slot(names, logs, checkpoints, outbox.put) for _ in range(slots)]

    def serve(self, listener: socket.socket) -> None:
        """Do what services say that connect to the listener."""
        while not self._is_closed and (channel := self._next_service(listener)) is not None:
            with channel:
                self._outbox.attach(channel)
                try:
                    with channel.makefile("rb") as lines:
                        for line in lines:
                            self._obey(json.loads(line))
                except (OSError, ValueError):  # cut off, perhaps within a line
                    pass
                self._outbox.detach()
        for slot in self._slots:
            slot.close()

    def _next_service(self, listener: socket.socket) -> socket.socket | None:
        """Wait for a service: long while something is in training, else briefly."""
        listener.settimeout(1.0)
        begun = time.monotonic()
        while True:
            try:
                channel, _ = listener.accept()
            except TimeoutError:
                patience = OUTAGE_SECONDS if self._outbox.is_busy else IDLE_OUTAGE_SECONDS
                if time.monotonic() - begun > patience:
                    return None
            else:
                channel.settimeout(None)
                return channel

    def _obey(self, command: dict[str, Any]) -> None:
        if command["do"] == "close":
            self._is_closed = True
            return
        if command["do"] == "acknowledge":
            self._outbox.acknowledge(command["count"])
            return
        slot = next((slot for slot in self._slots if slot.worker == command["worker"]), None)
        if slot is None:
            return
        if command["do"] == "train":
            slot.train(command)
        elif command["do"] == "drop":
            slot.drop(command["seeds"])
        elif command["do"] == "kill":
            slot.kill()


def drive(
    listener: socket.socket,
    workers: int,
    address: str,
    *,
    logs: Path,
    checkpoints: str,
    spool: Path,
    scratch: str,
) -> None:
    """Join the cluster, or make one of so many workers, and obey who connects to the listener."""
    if address:
        with _deadline(JOIN_SECONDS, f"Ray at {address} did not answer in {JOIN_SECONDS:.0f} s"):
            ray.init(address=address, log_to_driver=False, logging_level=logging.WARNING)
        resources: dict[str, float] = ray.cluster_resources()  # type: ignore[no-untyped-call]
        workers = int(resources.get("CPU", 0))
    else:
        with _deadline(START_SECONDS, f"Ray did not start in {START_SECONDS:.0f} s"):
            ray.init(
                address="local",
                num_cpus=workers,
                object_store_memory=OBJECT_STORE_BYTES,
                include_dashboard=False,
                log_to_driver=False,
                logging_level=logging.WARNING,
                _temp_dir=scratch,
            )
    threading.Thread(target=_watch_node, name="node watch", daemon=True).start()
    try:
        ActorPool(Outbox(spool), workers, logs, checkpoints).serve(listener)
    finally:
        ray.shutdown()


def _watch_node() -> None:
    """End the process when Ray counts the node that it is on as dead: no worker comes up there."""
    own = ray.get_runtime_context().get_node_id()
    while own in _living_nodes():
        time.sleep(NODE_CHECK_SECONDS)
    _give_up("Ray's node on this machine is dead: its raylet was killed, or did not answer")


def _living_nodes() -> set[str]:
    nodes: list[dict[str, Any]] = ray.nodes()  # type: ignore[no-untyped-call]
    return {node["NodeID"] for node in nodes if node["Alive"]}


def _give_up(complaint: str) -> None:
    """End the process with the complaint as its last words."""
    print(complaint, file=sys.stderr, flush=True)  # noqa: T201
    os._exit(1)


@contextmanager
def _deadline(seconds: float, complaint: str) -> Iterator[None]:
    """End the process, with the complaint as its last words, when the block takes longer.

    `ray.init` waits for ever for a cluster that does not answer, and cannot be interrupted.
    """
    timer = threading.Timer(seconds, _give_up, [complaint])
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
