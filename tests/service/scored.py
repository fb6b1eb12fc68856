"""Cells with chosen scores, and run curves with chosen values, without a store."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from service.run import RunStatus
from service.run_curve import RunCurve
from service.statistics.scores import CellScores
from workers.run_spec import RunSpec


def cell(
    label: str, environment: str, values: Sequence[float], seeds: Sequence[int] | None = None
) -> CellScores:
    """A cell whose runs have ended; its algorithm goes by the label."""
    return CellScores(
        spec=RunSpec(label, environment, 0),
        label=label,
        seeds=tuple(range(len(values)) if seeds is None else seeds),
        values=np.array(values, np.float64),
        ended=len(values),
    )


def run_curve(
    algorithm: str, environment: str, seed: int, values: Sequence[float], **fields: Any
) -> RunCurve:
    """A succeeded run measured at 800, 1600, ..."""
    status = fields.pop("status", RunStatus.SUCCEEDED)
    return RunCurve(
        run_id=f"{algorithm}-{environment}-{seed}",
        spec=RunSpec(algorithm, environment, seed, **fields),
        environment_version=1,
        status=status,
        x=np.array([800.0 * (k + 1) for k in range(len(values))]),
        values=np.array(values, np.float64),
    )
