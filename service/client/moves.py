"""Moves of sweeps and runs: cancel, pause, resume, retry, uncancel."""

from __future__ import annotations

from collections.abc import Sequence

from service.api.schemas.requests.bulk import BulkAnswer
from service.api.schemas.run_answer import RunAnswer
from service.api.schemas.sweep_answer import SweepAnswer
from service.client.connection import Connection, path_of
from service.model.move import Move
from service.model.run_name import is_run
from service.store.claiming.bulk import BulkMove


class Moves(Connection):
    """Calls that move sweeps and runs."""

    def move(self, identifier: str, move: Move) -> SweepAnswer | RunAnswer:
        """Cancel, pause, resume, retry or uncancel a sweep, or a single run.

        Args:
            identifier: a sweep's id, or a run's (`<sweep>-<number>`).
            move: "cancel", "pause", "resume", "retry" or "uncancel".

        Returns:
            The sweep or the run afterwards.
        """
        answer = self._call("POST", f"{path_of(identifier)}/{move}").content
        if is_run(identifier):
            return RunAnswer.model_validate_json(answer)
        return SweepAnswer.model_validate_json(answer)

    def cancel(self, identifier: str) -> SweepAnswer | RunAnswer:
        """Cancel a sweep or a run; its measurements stay."""
        return self.move(identifier, "cancel")

    def pause(self, identifier: str) -> SweepAnswer | RunAnswer:
        """Start no queued runs of a sweep, or not this run."""
        return self.move(identifier, "pause")

    def resume(self, identifier: str) -> SweepAnswer | RunAnswer:
        """Queue paused runs again."""
        return self.move(identifier, "resume")

    def retry(self, identifier: str) -> SweepAnswer | RunAnswer:
        """Queue failed runs again, and only those."""
        return self.move(identifier, "retry")

    def uncancel(self, identifier: str) -> SweepAnswer | RunAnswer:
        """Queue cancelled runs again, and only those."""
        return self.move(identifier, "uncancel")

    def move_all(self, identifiers: Sequence[str], move: BulkMove) -> BulkAnswer:
        """Move many sweeps and runs in one request.

        Args:
            identifiers: ids of sweeps and of runs.
            move: as for `move`; or "delete", "archive" or "unarchive", for sweeps alone.

        Returns:
            Which were moved, and why the others were not.
        """
        asked = {"move": move, "ids": list(identifiers)}
        return BulkAnswer.model_validate_json(self._call("POST", "/moves", json=asked).content)
