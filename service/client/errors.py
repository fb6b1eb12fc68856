"""What goes wrong between a client and its service."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import httpx2


class ServiceError(Exception):
    """The service refused a call or did not answer; the message says why and what to do.

    Attributes:
        status: the HTTP status; None where no answer came.
    """

    def __init__(self, message: str, status: int | None = None) -> None:
        """Keep the message and the status."""
        super().__init__(message)
        self.status = status


class SubmissionNotice(UserWarning):
    """A warning: a submitted sweep contains something that its author may not have meant."""


@contextmanager
def through_silence() -> Iterator[None]:
    """Suppress errors of a service that does not answer; its refusals are raised."""
    try:
        yield
    except ServiceError as error:
        if error.status is not None:
            raise


def problem_text(response: httpx2.Response) -> str:
    """A refusal (RFC 9457 problem) as text: what was wrong, field by field."""
    try:
        problem = response.json()
    except ValueError:
        return f"The service answered {response.status_code}: {response.text[:500]}"
    faults = [
        f"{error.get('field') or error.get('pointer') or ''}: {error.get('message', error)}"
        for error in problem.get("errors") or []
        if isinstance(error, dict)
    ]
    if len(faults) > 1:  # the detail is the first of them
        return faults_text(faults)
    return str(problem.get("detail") or problem.get("title") or response.status_code)


def faults_text(faults: Sequence[str]) -> str:
    """What is wrong with a request: one thing in a line, several in a list."""
    if len(faults) == 1:
        return faults[0]
    return "\n".join([f"{len(faults)} things are wrong:", *(f"  {fault}" for fault in faults)])
