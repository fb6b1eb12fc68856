"""Cells with chosen scores, and run curves with chosen values, without a store."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from service.analysis.statistics.scores import CellScores
from service.model.request.entry import Entries, OfEntry
from service.model.run import RunStatus
from service.model.run_curve import RunCurve
from workers.messages.run_spec import RunSpec


class ByAlgorithm(Entries):
    """Every algorithm of some runs is an entry, in the order of the runs."""

    def __init__(self, runs: Sequence[RunCurve]) -> None:
        """Take the runs as those of one sweep."""
        algorithms = dict.fromkeys(run.spec.algorithm for run in runs)
        environments = [run.spec.environment for run in runs]
        request = {"algorithms": [{"name": name} for name in algorithms]}
        super().__init__({**request, "environments": environments, "seeds": 1})

    def label(self, of_entry: OfEntry) -> str:
        """The run's algorithm."""
        assert isinstance(of_entry, RunCurve)
        return of_entry.spec.algorithm


def cell(
    label: str,
    environment: str,
    values: Sequence[float],
    seeds: Sequence[int] | None = None,
    statuses: Sequence[RunStatus] = (),
    place: int = 0,
) -> CellScores:
    """A cell whose runs succeeded, unless statuses say else; its algorithm goes by the label."""
    return CellScores(
        spec=RunSpec(label, environment, 0),
        label=label,
        place=place,
        seeds=tuple(range(len(values)) if seeds is None else seeds),
        values=np.array(values, np.float64),
        statuses=tuple(statuses) or (RunStatus.SUCCEEDED,) * len(values),
    )


def run_curve(
    algorithm: str, environment: str, seed: int, values: Sequence[float], **fields: Any
) -> RunCurve:
    """A succeeded run measured at 800, 1600, ..."""
    status = fields.pop("status", RunStatus.SUCCEEDED)
    processor = fields.pop("processor", "znver5")
    return RunCurve(
        entry=fields.pop("entry", 0),
        run_id=fields.pop("run_id", f"{algorithm}-{environment}-{seed}"),
        spec=RunSpec(algorithm, environment, seed, **fields),
        environment_version=1,
        status=status,
        x=np.array([800.0 * (k + 1) for k in range(len(values))]),
        processor=processor,
        values=np.array(values, np.float64),
    )
