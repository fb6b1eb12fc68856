"""Sweeps: submit, list, edit, extend, wait for, delete."""

from __future__ import annotations

import time
import uuid
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Literal

import httpx2

from service.api.schemas.listed_sweep_answer import ListedSweepAnswer
from service.api.schemas.page import Page
from service.api.schemas.requests.bulk import DeletionAnswer
from service.api.schemas.sweep_answer import DryRunAnswer, SweepAnswer, SweepHead
from service.client.connection import Connection
from service.client.errors import ServiceError, SubmissionNotice, through_silence
from service.client.request import Request, as_json
from service.model.sweep import SweepStatus


class Sweeps(Connection):
    """Calls that concern sweeps."""

    def submit(self, request: Request, key: str | None = None) -> SweepAnswer:
        """Queue a sweep and return it, with its id, once every run is stored.

        If the answer is lost on the way, the call is repeated once, and queues nothing twice.

        Args:
            request: the sweep; a mapping has the fields of `SweepRequest`.
            key: any text; a second submission with the same key returns the first sweep. By default
                each call queues a new sweep.

        Raises:
            ServiceError: if the sweep is invalid; the message lists every mistake.

        Warns:
            SubmissionNotice: for each of the answer's `notices`.
        """
        body, headers = as_json(request), {"Idempotency-Key": key or uuid.uuid4().hex}
        try:
            posted = self._call("POST", "/sweeps", json=body, headers=headers)
        except ServiceError as error:
            if error.status is not None or isinstance(error.__cause__, httpx2.ConnectError):
                raise
            posted = self._call("POST", "/sweeps", json=body, headers=headers)
        sweep = SweepAnswer.model_validate_json(posted.content)
        for notice in sweep.notices:
            warnings.warn(notice, SubmissionNotice, stacklevel=2)
        return sweep

    def estimate(self, request: Request) -> DryRunAnswer:
        """The runs that `submit` would queue, and their estimated cost; queues nothing."""
        dry = self._call("POST", "/sweeps", json=as_json(request), params={"dry_run": True})
        return DryRunAnswer.model_validate_json(dry.content)

    def sweep(self, sweep_id: str) -> SweepAnswer:
        """A sweep: status, numbers of runs by status, progress in [0, 1] and ETA in seconds."""
        return self._get(SweepAnswer, f"/sweeps/{sweep_id}")

    def sweeps(
        self,
        q: str | None = None,
        *,
        tag: str | None = None,
        algorithm: str | None = None,
        environment: str | None = None,
        status: SweepStatus | str | None = None,
        archived: bool | None = False,
        owner: str | None = None,
    ) -> Iterator[ListedSweepAnswer]:
        """Sweeps, newest first; fetched page by page while you iterate.

        Args:
            q: a text in the name, the notes or a tag, or the beginning of the id.
            tag: only sweeps with this tag.
            algorithm: only sweeps that compare this algorithm.
            environment: only sweeps with runs in this environment.
            status: only sweeps with this status.
            archived: None for all sweeps, True for archived ones alone.
            owner: only sweeps that this user submitted.
        """
        asked = {
            "q": q,
            "owner": owner,
            "tag": tag,
            "algorithm": algorithm,
            "environment": environment,
            "status": status,
            "archived": "all" if archived is None else str(archived).lower(),
        }
        given = {name: value for name, value in asked.items() if value is not None}
        return self._pages(Page[ListedSweepAnswer], "/sweeps", **given)

    def edit(
        self,
        sweep_id: str,
        *,
        name: str | None = None,
        notes: str | None = None,
        tags: Sequence[str] | None = None,
        archived: bool | None = None,
        priority: int | None = None,
        max_workers: int | Literal["any"] | None = None,
        webhook: str | Literal["none"] | None = None,
    ) -> SweepAnswer:
        """Change the description or priority of a sweep; None leaves a field as it is.

        Args:
            sweep_id: the sweep.
            name: its new name.
            notes: Markdown, which is shown as text.
            tags: tags that replace the present ones.
            archived: whether lists leave it out.
            priority: sweeps with a higher one start first.
            max_workers: how many may train its runs at once; "any" removes the limit.
            webhook: URL that is called when all runs have ended; "none" for none.
        """
        fields: dict[str, Any] = {
            "name": name,
            "notes": notes,
            "tags": None if tags is None else list(tags),
            "archived": archived,
            "priority": priority,
        }
        changes = {field: value for field, value in fields.items() if value is not None}
        if max_workers is not None:
            changes["max_workers"] = None if max_workers == "any" else max_workers
        if webhook is not None:
            changes["webhook"] = None if webhook == "none" else webhook
        answer = self._call("PATCH", f"/sweeps/{sweep_id}", json=changes)
        return SweepAnswer.model_validate_json(answer.content)

    def wait(
        self,
        sweep_id: str,
        timeout_seconds: float = float("inf"),
        progressed: Callable[[SweepAnswer], None] | None = None,
        poll_seconds: float = 1.0,
    ) -> SweepAnswer:
        """Block until every run of a sweep has ended, also while the service does not answer.

        Args:
            sweep_id: the sweep.
            timeout_seconds: how long to wait at most.
            progressed: called with the sweep after each poll.
            poll_seconds: time between two polls.

        Raises:
            TimeoutError: if the sweep has not ended in time.
            ServiceError: if the service refuses the call, such as for an unknown sweep.
        """
        deadline = time.monotonic() + timeout_seconds
        while True:
            with through_silence():
                sweep = self.sweep(sweep_id)
                if progressed is not None:
                    progressed(sweep)
                if has_ended(sweep):
                    return sweep
            if time.monotonic() > deadline:
                raise TimeoutError(f"Sweep {sweep_id} has not ended within {timeout_seconds:g} s.")
            time.sleep(poll_seconds)

    def add_seeds(self, sweep_id: str, seeds: Sequence[int]) -> SweepAnswer:
        """Add runs of these seeds to every curve of a sweep."""
        return self._add(sweep_id, {"seeds": list(seeds)})

    def add_entries(self, sweep_id: str, algorithms: Sequence[Mapping[str, Any]]) -> SweepAnswer:
        """Add entries to a sweep, with its seeds, in every one of its tasks.

        Args:
            sweep_id: the sweep.
            algorithms: as in a request.
        """
        return self._add(sweep_id, as_json({"algorithms": list(algorithms)}))

    def extend(self, sweep_id: str, timesteps: int) -> SweepAnswer:
        """Give the runs of a sweep more timesteps; ended runs go on from where they ended.

        They have the bits of runs that were as long from the start.
        """
        return self._add(sweep_id, {"timesteps": timesteps})

    def estimate_growth(
        self,
        sweep_id: str,
        *,
        seeds: Sequence[int] | None = None,
        algorithms: Sequence[Mapping[str, Any]] | None = None,
        timesteps: int | None = None,
    ) -> DryRunAnswer:
        """What `add_seeds`, `add_entries` or `extend` would queue, and its cost; queues nothing.

        Args:
            sweep_id: the sweep.
            seeds: seeds to add; or
            algorithms: entries to add; or
            timesteps: the new timesteps of its runs. The answer counts those that are added.
        """
        asked = {"seeds": seeds, "algorithms": algorithms, "timesteps": timesteps}
        added = {name: value for name, value in asked.items() if value is not None}
        path, params = f"/sweeps/{sweep_id}/runs", {"dry_run": True}
        dry = self._call("POST", path, json=as_json(added), params=params)
        return DryRunAnswer.model_validate_json(dry.content)

    def _add(self, sweep_id: str, added: Mapping[str, Any]) -> SweepAnswer:
        answer = self._call("POST", f"/sweeps/{sweep_id}/runs", json=added).content
        return SweepAnswer.model_validate_json(answer)

    def delete(self, sweep_id: str) -> DeletionAnswer:
        """Delete a sweep that has ended, with its measurements and policies, for good."""
        answer = self._call("DELETE", f"/sweeps/{sweep_id}").content
        return DeletionAnswer.model_validate_json(answer)


def has_ended(sweep: SweepHead) -> bool:
    """Whether every run of the sweep is final, and its question or search, if any, settled."""
    return sweep.status in (SweepStatus.FINISHED, SweepStatus.CANCELLED)
