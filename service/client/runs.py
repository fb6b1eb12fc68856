"""Runs: list them, look at them, follow the output of their workers."""

from __future__ import annotations

import time
from collections.abc import Iterator

from service.api.schemas.page import DEFAULT_LIMIT, Page
from service.api.schemas.run_answer import AttemptAnswer, ListedRunAnswer, RunAnswer
from service.client.connection import Connection
from service.client.errors import through_silence
from service.model.run import RunStatus
from service.store.reading.run_order import By


class Runs(Connection):
    """Calls that concern runs."""

    def run(self, run_id: str) -> RunAnswer:
        """One run, by its id (`<sweep>-<number>`)."""
        return self._get(RunAnswer, f"/runs/{run_id}")

    def runs(
        self,
        sweep_id: str,
        *,
        status: RunStatus | str | None = None,
        algorithm: str | None = None,
        environment: str | None = None,
        sort: By = "made",
        descending: bool = False,
        sparkline: int = 0,
        limit: int = DEFAULT_LIMIT,
    ) -> Iterator[ListedRunAnswer]:
        """The runs of a sweep, fetched page by page while you iterate.

        Args:
            sweep_id: the sweep.
            status: only runs with this status.
            algorithm: only runs of this algorithm.
            environment: only runs in this environment.
            sort: the value that they are sorted by.
            descending: whether the largest comes first.
            sparkline: about how many points of return_mean to include with each.
            limit: runs in a page.
        """
        asked = {"status": status, "algorithm": algorithm, "environment": environment}
        given = {name: value for name, value in asked.items() if value is not None}
        return self._pages(
            Page[ListedRunAnswer],
            f"/sweeps/{sweep_id}/runs",
            **given,
            sort=sort,
            descending=descending,
            sparkline=sparkline,
            limit=limit,
        )

    def attempts(self, run_id: str) -> list[AttemptAnswer]:
        """The attempts of a run, oldest first, with how each one ended."""
        return self._list(AttemptAnswer, f"/runs/{run_id}/attempts")

    def follow_log(self, run_id: str, poll_seconds: float = 1.0) -> Iterator[AttemptAnswer]:
        """The newest attempt of a run, whenever its `log_tail` has changed, until the run ended.

        Goes on while the service does not answer.

        Args:
            run_id: the run.
            poll_seconds: time between two looks.
        """
        seen: tuple[int, str] | None = None
        has_ended = False
        while not has_ended:
            with through_silence():
                is_final = self.run(run_id).status.is_final
                for attempt in self.attempts(run_id)[-1:]:
                    if seen != (attempt.attempt, attempt.log_tail):
                        seen = (attempt.attempt, attempt.log_tail)
                        yield attempt
                has_ended = is_final  # and all that was printed is told
            if not has_ended:
                time.sleep(poll_seconds)
