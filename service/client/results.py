"""Results of measurements: curves, scores, statistics, figures, reports."""

from __future__ import annotations

from typing import Literal

from service.analysis.comparison import Abscissa
from service.analysis.curves import Band
from service.analysis.figures.figure_form import Form
from service.analysis.figures.paper_figure import FigureNumber
from service.analysis.statistics.score import Score
from service.api.schemas.curves_answer import CurvesAnswer
from service.api.schemas.measured.scores_answer import ScoresAnswer
from service.api.schemas.question.verdict_answer import VerdictAnswer
from service.api.schemas.score_table_answer import ScoreTableAnswer
from service.api.schemas.search.search_answer import SearchAnswer
from service.api.schemas.statistics_answer import StatisticsAnswer
from service.client.connection import Connection, Option

DEFAULT_POINTS = 300

FigureOption = Option | float | list[str]
TableText = Literal["csv", "markdown", "latex"]


class Results(Connection):
    """Calls that fetch results of sweeps."""

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
            normalized: whether 0 acts at random and 1 is the best; None: for returns only.
            band: the statistic that the band shows.
            x: the abscissa.
            max_points: most points of a curve.
            seeds: whether to include the curve of each run.
            run: this run alone, by the number at the end of its id.
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

    def table_text(
        self, sweep_id: str, form: TableText, *, score: Score = "final", normalized: bool = True
    ) -> str:
        """The table of `table` as text: CSV, Markdown or LaTeX; same options."""
        asked = {"score": score, "normalized": normalized, "format": form}
        return self._call("GET", f"/sweeps/{sweep_id}/table", params=asked).text

    def statistics(self, sweep_id: str, *, score: Score = "final") -> StatisticsAnswer:
        """Statistics of the entries over all tasks, each with its interval and definition.

        Args:
            sweep_id: the sweep.
            score: which score of the runs.
        """
        return self._get(StatisticsAnswer, f"/sweeps/{sweep_id}/statistics", score=score)

    def verdict(self, sweep_id: str) -> VerdictAnswer:
        """The verdict on a sweep's question: an outcome and a sentence for each comparison.

        Args:
            sweep_id: a sweep that asks a question.
        """
        return self._get(VerdictAnswer, f"/sweeps/{sweep_id}/verdict")

    def search(self, sweep_id: str) -> SearchAnswer:
        """The rungs that the entries of a sweep's search have reached, and the best of each task.

        Args:
            sweep_id: a sweep that searches.
        """
        return self._get(SearchAnswer, f"/sweeps/{sweep_id}/search")

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
