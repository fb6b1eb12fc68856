"""What runs have learned: episodes, policies, diagnoses."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import algorithms
from service.analysis.diagnosis import FigureName as DiagnosisFigure
from service.analysis.figures.figure_form import Form
from service.api.schemas.diagnosis_answer import DiagnosisAnswer
from service.api.schemas.rollout_answer import RolloutAnswer
from service.client.connection import Connection, Option, path_of

if TYPE_CHECKING:
    from algorithms.acting.policy import TrainedPolicy


class Learned(Connection):
    """Calls that concern what runs have learned."""

    def rollout(self, run_id: str, seed: int = 0) -> RolloutAnswer:
        """An episode of a run's learned policy, from the start that the task draws for `seed`."""
        return self._get(RolloutAnswer, f"/runs/{run_id}/rollout", seed=seed)

    def policy(self, run_id: str) -> TrainedPolicy:
        """What a run has learned, to act with (`algorithms.TrainedPolicy`).

        It is that of the last checkpoint, or of the run's end. This call loads numba.

        Raises:
            ServiceError: while the run has no policy; `mpc` learns none.
        """
        return algorithms.load_policy(self.policy_file(run_id))

    def policy_file(self, run_id: str) -> bytes:
        """The policy as the content of a file, a NumPy archive (`.npz`)."""
        return self._call("GET", f"/runs/{run_id}/policy").content

    def diagnose(
        self,
        identifier: str,
        timeout_seconds: float = float("inf"),
        progressed: Callable[[DiagnosisAnswer], None] | None = None,
        poll_seconds: float = 1.0,
        **options: Option,
    ) -> DiagnosisAnswer:
        """Request the diagnosis of a run or a sweep, and block until it is made.

        Args:
            identifier: a run's id, or a sweep's, for its first runs that reached their end.
            timeout_seconds: how long to wait at most.
            progressed: called with the diagnosis after each poll.
            poll_seconds: time between two polls.
            options: of a sweep: query parameters of `POST /sweeps/{id}/diagnosis`, such as
                `seeds=4` or `environment="Pendulum"`.

        Returns:
            The findings; for a sweep, as medians over the seeds of each cell.

        Raises:
            TimeoutError: if it is not made in time; it goes on.
            ServiceError: if there is nothing to diagnose; the message says why.
        """
        path = f"{path_of(identifier)}/diagnosis"
        asked = self._call("POST", path, params=options)
        diagnosis = DiagnosisAnswer.model_validate_json(asked.content)
        deadline = time.monotonic() + timeout_seconds
        while diagnosis.waiting:
            if progressed is not None:
                progressed(diagnosis)
            if time.monotonic() > deadline:
                raise TimeoutError(
                    f"{diagnosis.waiting} diagnoses of {identifier} are not made within "
                    f"{timeout_seconds:g} s."
                )
            time.sleep(poll_seconds)
            diagnosis = self.diagnosis(identifier, **options)
        return diagnosis

    def diagnosis(self, identifier: str, **options: Option) -> DiagnosisAnswer:
        """The findings so far about a run or a sweep; requests nothing new.

        Args:
            identifier: a run's id, or a sweep's.
            options: of a sweep: query parameters of `GET /sweeps/{id}/diagnosis`.
        """
        return self._get(DiagnosisAnswer, f"{path_of(identifier)}/diagnosis", **options)

    def diagnosis_figure(
        self, identifier: str, figure: DiagnosisFigure, form: Form = "png", **options: Option
    ) -> bytes:
        """A figure of the findings about a run or a sweep, as the bytes of a file.

        Args:
            identifier: a run's id, or a sweep's.
            figure: "smoothing", "growth", "critic" or "loss".
            form: "png", "svg" or "pdf".
            options: of a sweep: query parameters of `GET /sweeps/{id}/diagnosis/{figure}.{form}`.
        """
        path = f"{path_of(identifier)}/diagnosis/{figure}.{form}"
        return self._call("GET", path, params=options).content
