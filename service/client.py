"""The Python client: submit sweeps, follow them, fetch what they measured.

    client = Client()                                   # the service on this machine
    sweep = client.submit({"algorithms": [{"name": "ddpg"}], "environments": ["Pendulum"],
                           "seeds": 4, "timesteps": 20_000})
    client.wait(sweep.id)
    curves = client.curves(sweep.id, normalized=True)

Answers are the service's own models (`service.api.schemas`), as the OpenAPI document shows them.
Importing this module loads neither numba nor torch nor ray.
"""

from __future__ import annotations

import csv
import io
import os
import ssl
import time
import uuid
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Self, TypeVar

import httpx2
from pydantic import BaseModel

import algorithms
from service.address import is_on_loopback, url_of
from service.analysis.comparison import Abscissa
from service.analysis.curves import Band
from service.analysis.diagnosis import FigureName as DiagnosisFigure
from service.analysis.figures.figure_form import Form
from service.analysis.figures.paper_figure import FigureNumber
from service.analysis.statistics.score import Score
from service.api.schemas.curves_answer import CurvesAnswer
from service.api.schemas.diagnosis_answer import DiagnosisAnswer
from service.api.schemas.listed_sweep_answer import ListedSweepAnswer
from service.api.schemas.measured.measurements_answer import MeasurementsAnswer
from service.api.schemas.measured.scores_answer import ScoresAnswer
from service.api.schemas.number import unsayable
from service.api.schemas.page import DEFAULT_LIMIT, Page
from service.api.schemas.people import (
    DAYS,
    NewShareAnswer,
    NewUserAnswer,
    SessionAnswer,
    ShareAnswer,
    SignInAnswer,
    UserAnswer,
)
from service.api.schemas.question.verdict_answer import VerdictAnswer
from service.api.schemas.readiness_answer import ReadinessAnswer
from service.api.schemas.requests.bulk import BulkAnswer, DeletionAnswer
from service.api.schemas.requests.sweep_request import SweepRequest
from service.api.schemas.rollout_answer import RolloutAnswer
from service.api.schemas.run_answer import AttemptAnswer, ListedRunAnswer, RunAnswer
from service.api.schemas.score_table_answer import ScoreTableAnswer
from service.api.schemas.search.search_answer import SearchAnswer
from service.api.schemas.statistics_answer import StatisticsAnswer
from service.api.schemas.sweep_answer import DryRunAnswer, SweepAnswer, SweepHead
from service.export.measured_run import MeasuredRun, measured_runs
from service.extras import required
from service.model.caller import Scope
from service.model.move import Move
from service.model.run import RunStatus
from service.model.run_name import is_run
from service.model.sweep import SweepStatus
from service.store.claiming.bulk import BulkMove
from service.store.reading.run_order import By

if TYPE_CHECKING:
    from algorithms.acting.policy import TrainedPolicy

API = "/api/v1"
DEFAULT_POINTS = 300

Option = str | bool | int
FigureOption = Option | float | list[str]
TableText = Literal["csv", "markdown", "latex"]
Answer = TypeVar("Answer", bound=BaseModel)
Request = SweepRequest | Mapping[str, Any]


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


def find_token() -> str:
    """The token to call a service with.

    That is `D3PG_TOKEN`, else the content of the file `D3PG_TOKEN_FILE`, else of the file `token`
    in `D3PG_DATA_DIR` (./d3pg-data).

    Raises:
        ServiceError: if none is there, or the file can be read by other users.
    """
    if token := os.environ.get("D3PG_TOKEN"):
        return token
    named = os.environ.get("D3PG_TOKEN_FILE")
    file = Path(named or Path(os.environ.get("D3PG_DATA_DIR") or "d3pg-data") / "token")
    try:
        if file.stat().st_mode & 0o077:
            raise ServiceError(
                f"{file} can be read by other users, so its token is no secret: run chmod 600 "
                f"{file}, or have another token made if you do not trust them."
            )
        return file.read_text(encoding="utf-8").strip()
    except OSError as error:
        raise ServiceError(
            f"No token: D3PG_TOKEN is not set and {file} cannot be read ({error.strerror}). "
            "Start the service here with `d3pg serve`, name its data directory with "
            "D3PG_DATA_DIR, or a file with a token of yours with D3PG_TOKEN_FILE."
        ) from error


def own_url() -> str:
    """Where a service with this environment's settings is found."""
    has_tls = bool(os.environ.get("D3PG_TLS_CERTIFICATE"))
    if has_tls and (public := os.environ.get("D3PG_PUBLIC_URL")):
        return public  # it has the name that the certificate is for
    port = os.environ.get("D3PG_PORT") or "8000"
    host = os.environ.get("D3PG_HOST") or "127.0.0.1"
    return url_of(host, port, "https" if has_tls else "http")


def trusted() -> ssl.SSLContext | bool:
    """Whom to believe over TLS: the usual authorities, and a service with our settings."""
    certificate = os.environ.get("D3PG_TLS_CERTIFICATE")
    if not certificate:
        return True
    context = ssl.create_default_context()
    context.load_verify_locations(certificate)
    return context


class Client:
    """A connection to one service; usable as a context manager.

    Every method that calls the service raises `ServiceError` if the service refuses the call or
    does not answer.

    Attributes:
        url: the service's address.
        token: the access token.
    """

    def __init__(
        self, url: str | None = None, token: str | None = None, timeout_seconds: float = 60.0
    ) -> None:
        """Make a client; the first call opens the connection.

        Args:
            url: the service's address; by default `D3PG_URL`, else the one that a service with
                `D3PG_HOST` (127.0.0.1) and `D3PG_PORT` (8000) listens on. A service on this machine
                is asked directly, whatever proxies the environment names.
            token: the access token; by default that of `find_token`.
            timeout_seconds: how long each call waits for the service.

        Raises:
            ServiceError: if no token is given or found.
        """
        self.url = url or os.environ.get("D3PG_URL") or own_url()
        self.token = token or find_token()
        self._http = httpx2.Client(
            base_url=self.url,
            headers={"Authorization": f"Bearer {self.token}"},
            timeout=timeout_seconds,
            trust_env=not is_on_loopback(self.url),
            verify=trusted(),
        )

    def __enter__(self) -> Self:
        """Close with the block."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the connections."""
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

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
            tag: those that have it.
            algorithm: those that compare it.
            environment: those with runs in it.
            status: those that stand there.
            archived: None for all sweeps, True for archived ones alone.
            owner: those that they submitted.
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
        """Change how a sweep is described, found and ranked; None leaves a field as it is.

        Args:
            sweep_id: the sweep.
            name: its new name.
            notes: Markdown, which is shown as text.
            tags: replace those that it has.
            archived: whether lists leave it out.
            priority: sweeps with a higher one start first.
            max_workers: how many may train its runs at once; "any" lifts the limit.
            webhook: URL that is told when all runs have ended; "none" for none.
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
            status: those that stand there.
            algorithm: those of it.
            environment: those in it.
            sort: by what they are listed.
            descending: whether the largest comes first.
            sparkline: about so many points of return_mean with each.
            limit: of a page.
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
        """Cancel a sweep or a run; what it measured stays."""
        return self.move(identifier, "cancel")

    def pause(self, identifier: str) -> SweepAnswer | RunAnswer:
        """Start none of the queued runs of a sweep, or not this run."""
        return self.move(identifier, "pause")

    def resume(self, identifier: str) -> SweepAnswer | RunAnswer:
        """Queue what was paused."""
        return self.move(identifier, "resume")

    def retry(self, identifier: str) -> SweepAnswer | RunAnswer:
        """Queue failed runs again, and only those."""
        return self.move(identifier, "retry")

    def uncancel(self, identifier: str) -> SweepAnswer | RunAnswer:
        """Queue cancelled runs again, and only those."""
        return self.move(identifier, "uncancel")

    def move_all(self, identifiers: Sequence[str], move: BulkMove) -> BulkAnswer:
        """Ask many sweeps and runs for a move in one request.

        Args:
            identifiers: ids of sweeps and of runs.
            move: as for `move`; or "delete", "archive" or "unarchive", for sweeps alone.

        Returns:
            Which were moved, and why the others were not.
        """
        asked = {"move": move, "ids": list(identifiers)}
        return BulkAnswer.model_validate_json(self._call("POST", "/moves", json=asked).content)

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
        """Give the runs of a sweep more timesteps; those that ended go on from where they did.

        They come to the bits of runs that were as long from the start.
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
            seeds: to be added; or
            algorithms: to be added; or
            timesteps: that its runs are to have. The answer counts those that are added.
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
        """Delete a sweep that has ended, with all that it measured and learned, for good."""
        answer = self._call("DELETE", f"/sweeps/{sweep_id}").content
        return DeletionAnswer.model_validate_json(answer)

    def measurements(self, run_id: str) -> MeasurementsAnswer:
        """Every measurement of a run, as columns of equal length."""
        return self._get(MeasurementsAnswer, f"/runs/{run_id}/measurements")

    def measurements_csv(self, run_id: str) -> str:
        """Every measurement of a run as CSV, including NaN and infinity."""
        path, params = f"/runs/{run_id}/measurements", {"format": "csv"}
        return self._call("GET", path, params=params).text

    def measurement_rows(self, run_id: str) -> list[dict[str, str]]:
        """Every measurement of a run as rows; numbers are text with all their digits."""
        return list(csv.DictReader(io.StringIO(self.measurements_csv(run_id))))

    def sweep_csv(self, sweep_id: str) -> str:
        """Every measurement of all runs of a sweep as CSV, a line a measurement; one request."""
        return self._call("GET", f"/sweeps/{sweep_id}/measurements").text

    def sweep_csv_parts(self, sweep_id: str) -> Iterator[str]:
        """The same text in parts, as they arrive; nothing holds it whole."""
        with self._streamed(f"/sweeps/{sweep_id}/measurements") as answer:
            yield from answer.iter_text()

    def save_measurements(
        self, sweep_id: str, file: Path, form: Literal["csv", "parquet"] = "csv"
    ) -> int:
        """Write every measurement of a sweep to a file, as it arrives; nothing holds it whole.

        Returns:
            The number of bytes.
        """
        with (
            self._streamed(f"/sweeps/{sweep_id}/measurements", format=form) as answer,
            file.open("wb") as opened,
        ):
            return sum(opened.write(part) for part in answer.iter_bytes())

    def measured_runs(self, sweep_id: str) -> Iterator[MeasuredRun]:
        """The runs of a sweep that measured anything, each with all of it, one after the other."""
        with self._streamed(f"/sweeps/{sweep_id}/measurements") as answer:
            yield from measured_runs(answer.iter_lines())

    def to_pandas(self, sweep_id: str) -> Any:
        """Every measurement of a sweep as a `pandas.DataFrame`, a row a measurement."""
        return required("pandas", "pandas").read_csv(io.StringIO(self.sweep_csv(sweep_id)))

    def scores(
        self, sweep_id: str, *, score: Score = "final", normalized: bool = True
    ) -> ScoresAnswer:
        """The score of every run of a sweep, by entry and task; same options as `table`."""
        path = f"/sweeps/{sweep_id}/scores"
        return self._get(ScoresAnswer, path, score=score, normalized=normalized)

    def curves(
        self,
        sweep_id: str,
        *,
        metric: str = "return_mean",
        normalized: bool | None = None,
        band: Band = "std",
        x: Abscissa = "timesteps",
        max_points: int = DEFAULT_POINTS,
        seeds: bool = False,
        run: int | None = None,
    ) -> CurvesAnswer:
        """Mean and band over seeds of every entry in every task.

        Args:
            sweep_id: the sweep.
            metric: a return, or a diagnostic that the runs measure.
            normalized: whether 0 acts at random and 1 is the best; None: of returns.
            band: what it shows.
            x: the abscissa.
            max_points: of a curve.
            seeds: each run's own curve too.
            run: of this run alone, by the number at the end of its id.
        """
        asked = {
            "metric": metric,
            "normalized": normalized,
            "band": band,
            "x": x,
            "max_points": max_points,
            "seeds": seeds,
            "run": run,
        }
        given = {name: value for name, value in asked.items() if value is not None}
        return self._get(CurvesAnswer, f"/sweeps/{sweep_id}/curves", **given)

    def table(
        self, sweep_id: str, *, score: Score = "final", normalized: bool = True
    ) -> ScoreTableAnswer:
        """The score of every entry in every task.

        Args:
            sweep_id: the sweep.
            score: which one.
            normalized: whether 0 acts at random and 1 is the best.
        """
        path = f"/sweeps/{sweep_id}/table"
        return self._get(ScoreTableAnswer, path, score=score, normalized=normalized)

    def statistics(self, sweep_id: str, *, score: Score = "final") -> StatisticsAnswer:
        """Statistics of the entries over all tasks, each with its interval and definition.

        Args:
            sweep_id: the sweep.
            score: of the runs.
        """
        return self._get(StatisticsAnswer, f"/sweeps/{sweep_id}/statistics", score=score)

    def verdict(self, sweep_id: str) -> VerdictAnswer:
        """What a sweep's question has come to: an outcome and a sentence for each comparison.

        Args:
            sweep_id: a sweep that asks a question.
        """
        return self._get(VerdictAnswer, f"/sweeps/{sweep_id}/verdict")

    def search(self, sweep_id: str) -> SearchAnswer:
        """How far the entries of a sweep's search have climbed, and which is the best of each task.

        Args:
            sweep_id: a sweep that searches.
        """
        return self._get(SearchAnswer, f"/sweeps/{sweep_id}/search")

    def table_text(
        self, sweep_id: str, form: TableText, *, score: Score = "final", normalized: bool = True
    ) -> str:
        """The table of `table` as text: CSV, Markdown or LaTeX; same options."""
        asked = {"score": score, "normalized": normalized, "format": form}
        return self._call("GET", f"/sweeps/{sweep_id}/table", params=asked).text

    def report(self, sweep_id: str) -> str:
        """Curves, scores, statistics, settings and how to repeat them, as one HTML file.

        Args:
            sweep_id: the sweep; or several, joined by `+`.
        """
        return self._call("GET", f"/sweeps/{sweep_id}/report").text

    def figure(
        self,
        sweep_id: str,
        form: Form = "png",
        number: FigureNumber | None = None,
        **options: FigureOption,
    ) -> bytes:
        """A figure as the bytes of a file.

        Args:
            sweep_id: the sweep.
            form: "png", "svg" or "pdf".
            number: which of the paper's figures, "2" to "6"; by default every curve of the sweep.
            options: query parameters of `GET /sweeps/{id}/plot.{form}`, such as
                `metric=["return_mean"]`, `entry=["ddpg", "hybrid-ddpg"]`, `band="ci95"` or
                `columns=1`; the paper's figures take none.
        """
        name = f"plot.{form}" if number is None else f"figures/{number}.{form}"
        return self._call("GET", f"/sweeps/{sweep_id}/{name}", params=options).content

    def figure_data(
        self, sweep_id: str, number: FigureNumber | None = None, **options: FigureOption
    ) -> str:
        """The numbers of `figure` with the same number and options, as CSV."""
        name = "plot" if number is None else f"figures/{number}"
        return self._call("GET", f"/sweeps/{sweep_id}/{name}.csv", params=options).text

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
        """The same as the content of a file, a NumPy archive (`.npz`)."""
        return self._call("GET", f"/runs/{run_id}/policy").content

    def diagnose(
        self,
        identifier: str,
        timeout_seconds: float = float("inf"),
        progressed: Callable[[DiagnosisAnswer], None] | None = None,
        poll_seconds: float = 1.0,
        **options: Option,
    ) -> DiagnosisAnswer:
        """Ask for the diagnosis of a run or a sweep, and block until it is made.

        Args:
            identifier: a run's id, or a sweep's: of its first runs that reached their end.
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
        """What was found so far about a run or a sweep; asks for nothing new.

        Args:
            identifier: a run's id, or a sweep's.
            options: of a sweep: query parameters of `GET /sweeps/{id}/diagnosis`.
        """
        return self._get(DiagnosisAnswer, f"{path_of(identifier)}/diagnosis", **options)

    def diagnosis_figure(
        self, identifier: str, figure: DiagnosisFigure, form: Form = "png", **options: Option
    ) -> bytes:
        """A figure of what was found about a run or a sweep, as the bytes of a file.

        Args:
            identifier: a run's id, or a sweep's.
            figure: "smoothing", "growth", "critic" or "loss".
            form: "png", "svg" or "pdf".
            options: of a sweep: query parameters of `GET /sweeps/{id}/diagnosis/{figure}.{form}`.
        """
        path = f"{path_of(identifier)}/diagnosis/{figure}.{form}"
        return self._call("GET", path, params=options).content

    def users(self) -> list[UserAnswer]:
        """Users by name, those that were revoked too; for administrators."""
        return self._list(UserAnswer, "/users")

    def add_user(self, name: str, scope: Scope | str) -> NewUserAnswer:
        """Make a user; the answer tells the token, this once. For administrators.

        Args:
            name: lower case letters, digits, and `._-` after the first.
            scope: "metrics", "read", "submit" or "admin".
        """
        asked = {"name": name, "scope": str(scope)}
        answer = self._call("POST", "/users", json=asked)
        return NewUserAnswer.model_validate_json(answer.content)

    def revoke_user(self, name: str) -> UserAnswer:
        """Take a user's token away, with its sessions and shares; for administrators."""
        answer = self._call("DELETE", f"/users/{name}")
        return UserAnswer.model_validate_json(answer.content)

    def share(
        self, sweep_ids: Sequence[str], *, days: int = DAYS, page: str | None = None
    ) -> NewShareAnswer:
        """Make a link that lets whoever has it read some sweeps, for a time.

        Args:
            sweep_ids: the sweeps.
            days: until it expires.
            page: the path that it opens, such as "/compare?sweep=ID&sweep=ID&band=ci95"; by default
                the page of the sweep, or the comparison of several.
        """
        asked = {"sweeps": list(sweep_ids), "days": days, "page": page}
        answer = self._call("POST", "/shares", json=asked)
        return NewShareAnswer.model_validate_json(answer.content)

    def shares(self) -> list[ShareAnswer]:
        """The shares that have not expired: one's own, for an administrator those of all."""
        return self._list(ShareAnswer, "/shares")

    def revoke_share(self, share_id: str) -> ShareAnswer:
        """Take a share back, at once."""
        answer = self._call("DELETE", f"/shares/{share_id}")
        return ShareAnswer.model_validate_json(answer.content)

    def sign_in_link(self, page: str = "/") -> SignInAnswer:
        """A link that signs a browser in, once, within ten minutes.

        Args:
            page: the path that it opens.
        """
        answer = self._call("POST", "/sign-in-links", json={"page": page})
        return SignInAnswer.model_validate_json(answer.content)

    def sessions(self) -> list[SessionAnswer]:
        """The browsers that are signed in: one's own, for an administrator those of all."""
        return self._list(SessionAnswer, "/sessions")

    def end_session(self, session_id: str) -> SessionAnswer:
        """Sign a browser out, at once."""
        answer = self._call("DELETE", f"/sessions/{session_id}")
        return SessionAnswer.model_validate_json(answer.content)

    def catalogue_names(self, kind: Literal["algorithms", "environments"]) -> dict[str, str]:
        """The names of the algorithms or of the tasks, each with a line on it, if there is one."""
        listed = self._call("GET", "/catalogue").json()[kind]
        return {each["name"]: str(each.get("summary", "")) for each in listed}

    def readiness(self) -> ReadinessAnswer:
        """The state of database and cluster (`/readyz`), whether they are ready or not."""
        answer = self._call("GET", "/readyz", allowed=(503,), prefix="")
        return ReadinessAnswer.model_validate_json(answer.content)

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

    def _get(self, model: type[Answer], path: str, **params: Any) -> Answer:
        return model.model_validate_json(self._call("GET", path, params=params).content)

    def _list(self, model: type[Answer], path: str) -> list[Answer]:
        return [model.model_validate(each) for each in self._call("GET", path).json()]

    def _pages(self, model: type[Page[Answer]], path: str, **params: Any) -> Iterator[Answer]:
        cursor: dict[str, str] = {}
        while True:
            page = self._get(model, path, **params, **cursor)
            yield from page.items
            if page.next is None:
                return
            cursor = {"after": page.next}

    def _call(
        self,
        method: str,
        path: str,
        allowed: tuple[int, ...] = (),
        prefix: str = API,
        **options: Any,
    ) -> httpx2.Response:
        try:
            response = self._http.request(method, prefix + path, **options)
        except httpx2.TransportError as error:
            raise self._silence(error) from error
        if response.is_success or response.status_code in allowed:
            return response
        raise ServiceError(problem_text(response), response.status_code)

    @contextmanager
    def _streamed(self, path: str, **params: Any) -> Iterator[httpx2.Response]:
        """An answer that is read as it arrives."""
        try:
            with self._http.stream("GET", API + path, params=params) as response:
                if not response.is_success:
                    response.read()
                    raise ServiceError(problem_text(response), response.status_code)
                yield response
        except httpx2.TransportError as error:
            raise self._silence(error) from error

    def _silence(self, error: httpx2.TransportError) -> ServiceError:
        return ServiceError(
            f"No service answers at {self.url} ({error}). Start one with `d3pg serve`, or "
            "name another with D3PG_URL."
        )


@contextmanager
def through_silence() -> Iterator[None]:
    """Go on where the service does not answer; what it refuses is raised."""
    try:
        yield
    except ServiceError as error:
        if error.status is not None:
            raise


def as_json(request: Request) -> dict[str, Any]:
    """What is posted: of a model the fields that were set, a mapping as it stands.

    Raises ServiceError, with every value that JSON cannot say.
    """
    if isinstance(request, SweepRequest):
        return request.model_dump(mode="json", exclude_unset=True)
    try:
        faults = list(unsayable("", request))
    except RecursionError:
        raise ServiceError("The request contains itself.") from None
    if faults:
        raise ServiceError(faults_text(faults))
    return dict(request)


def path_of(identifier: str) -> str:
    """Where a sweep or a run is found."""
    return f"/{'runs' if is_run(identifier) else 'sweeps'}/{identifier}"


def has_ended(sweep: SweepHead) -> bool:
    """Whether every run of the sweep is final, and its question or search, if any, settled."""
    return sweep.status in (SweepStatus.FINISHED, SweepStatus.CANCELLED)


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
