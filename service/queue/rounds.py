"""Work that is done every few seconds, on a thread of its own, for as long as there is any."""

import threading
from abc import ABC, abstractmethod

import structlog

log = structlog.get_logger(__name__)

ROUND_SECONDS = 5.0
STOP_SECONDS = 1.0


class Rounds(ABC):
    """`start` begins, `stop` ends. A round that fails is tried again."""

    def __init__(self, name: str, seconds: float = ROUND_SECONDS) -> None:
        """Begin nothing yet; `name` describes the work, `seconds` is the length of a pause."""
        self._name = name
        self._seconds = seconds
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """Stop after the present round, or leave it running if a place for files does not answer.

        The next service does what was left.
        """
        self._stopping.set()
        self._thread.join(STOP_SECONDS)

    @abstractmethod
    def work(self) -> bool:
        """Do some of the work; return whether there may be more."""

    def _run(self) -> None:
        while not self._stopping.wait(self._seconds):
            try:
                while self.work() and not self._stopping.is_set():
                    pass
            except OSError as trouble:
                log.warning("something must wait", what=self._name, reason=trouble.strerror)
            except Exception:  # the database refuses
                log.exception("something must wait", what=self._name)
