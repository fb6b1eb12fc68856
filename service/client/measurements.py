"""Measurements, in every form."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

from service.api.schemas.measured.measurements_answer import MeasurementsAnswer
from service.client.connection import Connection
from service.export.measured_run import MeasuredRun, measured_runs
from service.extras import required


class Measurements(Connection):
    """Calls that fetch measurements."""

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
        """The same text in parts, as they arrive; it is never held completely."""
        with self._streamed(f"/sweeps/{sweep_id}/measurements") as answer:
            yield from answer.iter_text()

    def sweep_rows(self, sweep_id: str) -> Iterator[dict[str, str]]:
        """The same as rows, as they arrive; numbers are text with all their digits."""
        with self._streamed(f"/sweeps/{sweep_id}/measurements") as answer:
            yield from csv.DictReader(answer.iter_lines())

    def save_measurements(
        self, sweep_id: str, file: Path, form: Literal["csv", "parquet"] = "csv"
    ) -> int:
        """Write every measurement of a sweep to a file, as it arrives; it is never held completely.

        Returns:
            The number of bytes.
        """
        with (
            self._streamed(f"/sweeps/{sweep_id}/measurements", format=form) as answer,
            file.open("wb") as opened,
        ):
            return sum(opened.write(part) for part in answer.iter_bytes())

    def measured_runs(self, sweep_id: str) -> Iterator[MeasuredRun]:
        """The runs of a sweep that have measurements, one by one, each with all of them."""
        with self._streamed(f"/sweeps/{sweep_id}/measurements") as answer:
            yield from measured_runs(answer.iter_lines())

    def to_pandas(self, sweep_id: str) -> Any:
        """Every measurement of a sweep as a `pandas.DataFrame`, a row a measurement."""
        return required("pandas", "pandas").read_csv(io.StringIO(self.sweep_csv(sweep_id)))
