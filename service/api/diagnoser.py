"""The diagnoser: makes the diagnoses that are asked for, one after the other.

They are made in a process of its own, for a few seconds each, so that they hold up neither the
service nor its figures and rollouts. The waiting ones are in the database, so none is forgotten
when the service dies: the next one goes on.
"""

import threading
from collections.abc import Iterable, Sequence

import structlog

from algorithms.diagnostics.finding import Finding
from service.api.learned import Learned
from service.api.load.side_process import OwnSide
from service.api.refusals.problems import ImpossibleMove, ServiceBusy
from service.model.run import Run
from service.store.store import Store
from service.task_shelf import TaskShelf
from workers.checkpoints.place import Place

log = structlog.get_logger(__name__)

LIMIT_SECONDS = 300.0
"""Of one diagnosis, which may have to compile kernels first."""
MOST_WAITING = 512
RETRY_SECONDS = 5.0
STOP_SECONDS = 5.0


class UndiagnosedError(Exception):
    """There can be no findings; the text is the sentence that says why."""


class Diagnoser:
    """Works on a thread of its own. `start` begins, `stop` ends."""

    def __init__(self, store: Store, checkpoints: Place, side: OwnSide, shelf: TaskShelf) -> None:
        """Begin nothing yet; `side` is where diagnoses are made."""
        self._store = store
        self._side = side
        self._learned = Learned(checkpoints, side, shelf)
        self._asked = threading.Event()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="diagnoser", daemon=True)

    def start(self) -> None:
        """Start the thread, with what an earlier service has left waiting."""
        self._thread.start()

    def stop(self) -> None:
        """Stop at once. What is under way waits for the next service."""
        self._stopping.set()
        self._asked.set()
        self._side.close()
        if self._thread.ident is not None:
            self._thread.join(STOP_SECONDS)

    def ask(self, runs: Sequence[Run]) -> None:
        """Ask for diagnoses of runs of one sweep that have ended; raises TooManyAskedError."""
        self._store.ask_diagnoses(runs, MOST_WAITING)
        self._asked.set()

    def work(self) -> None:
        """Make every diagnosis that waits."""
        while (run := self._store.next_waiting_diagnosis()) is not None:
            findings, problem = self._outcome(run)
            if self._stopping.is_set():
                return
            self._store.record_diagnosis(run, findings, problem)

    def _run(self) -> None:
        while not self._stopping.is_set():
            self._asked.clear()
            try:
                self.work()
            except Exception:  # the database refuses: tried again
                log.exception("diagnoses could not be made")
                self._stopping.wait(RETRY_SECONDS)
            else:
                self._asked.wait()

    def _outcome(self, run: Run) -> tuple[Iterable[Finding] | None, str]:
        try:
            return self._findings(run), ""
        except UndiagnosedError as error:
            return None, str(error)

    def _findings(self, run: Run) -> Iterable[Finding]:
        """Diagnose a run. Raises UndiagnosedError."""
        try:
            found = self._learned.call("workers.policies.diagnosis:diagnosis", run)
        except (ImpossibleMove, ServiceBusy) as refusal:
            raise UndiagnosedError(str(refusal.detail)) from refusal
        except Exception as error:
            log.warning("a diagnosis failed", run_id=run.id, exc_info=error)
            reason = f"The diagnosis of run {run.id} failed: {error}"
            raise UndiagnosedError(reason) from error
        return list(found)
