"""Curves of a sweep, as answers show them: columns of numbers, panel by panel.

Encoded by hand: 14,000 points of four numbers would take a validating model seconds.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from service.analysis.comparison import Comparison, LabelledCurve, Panel, definition
from service.analysis.curves import Floats
from service.api.schemas.number import Numbers, numbers
from service.api.schemas.run_answer import WeightsAnswer
from service.api.schemas.tabular import Tabular


class SeedAnswer(BaseModel):
    """One run of a curve, on the curve's x."""

    seed: int
    run_id: str
    values: Numbers


class CurveAnswer(BaseModel):
    """Mean and band over the runs of one entry; null where a number is not defined."""

    algorithm: str
    weights: WeightsAnswer
    config: dict[str, Any]
    label: str = Field(description="Name of its entry in the request.")
    runs: int
    unfinished: dict[str, int] = Field(
        description="Runs that have not reached their end, by status; they count as far as they "
        "were measured."
    )
    x: list[float]
    mean: Numbers
    low: Numbers
    high: Numbers
    n: list[int] = Field(description="Runs with a finite value there.")
    seeds: list[SeedAnswer] | None = Field(default=None, description="Only with `seeds=true`.")


class RandomReturnAnswer(BaseModel):
    """The zero of the normalised scale, with its 95 % interval."""

    mean: float
    low: float
    high: float
    episodes: int


class PanelAnswer(BaseModel):
    """The curves of one environment."""

    environment: str
    random_return: RandomReturnAnswer | None
    curves: list[CurveAnswer]


class CurvesAnswer(Tabular):
    """The curves of a sweep. Numbers are rounded to nine significant digits."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "sweep": "3f9a0c51b7de",
                    "metric": "return_mean",
                    "normalized": True,
                    "band": "std",
                    "x": "timesteps",
                    "definition": "Mean and one standard deviation (ddof 1) over the n runs ...",
                    "panels": [
                        {
                            "environment": "Pendulum",
                            "random_return": {
                                "mean": -1231.5,
                                "low": -1249.8,
                                "high": -1213.2,
                                "episodes": 1000,
                            },
                            "curves": [
                                {
                                    "algorithm": "ddpg",
                                    "weights": {"w1": 0.0, "w2": 0.0},
                                    "config": {},
                                    "label": "ddpg",
                                    "runs": 4,
                                    "unfinished": {},
                                    "x": [800, 1600],
                                    "mean": [0.012, 0.154],
                                    "low": [-0.021, 0.08],
                                    "high": [0.045, 0.228],
                                    "n": [4, 4],
                                }
                            ],
                        }
                    ],
                }
            ]
        }
    )

    sweep: str
    metric: str
    normalized: bool
    band: str
    x: str
    definition: str = Field(description="What the curves show, in words.")
    panels: list[PanelAnswer]

    def records(self) -> Iterator[dict[str, Any]]:
        """Yield a record a point of a curve; with `seeds=true`, one a point of a run."""
        for panel in self.panels:
            for curve in panel.curves:
                told = {
                    "environment": panel.environment,
                    "label": curve.label,
                    "algorithm": curve.algorithm,
                }
                columns = [curve.x, curve.mean, curve.low, curve.high, curve.n]
                for place, point in enumerate(zip(*columns, strict=True)):
                    row = told | dict(zip((self.x, "mean", "low", "high", "n"), point, strict=True))
                    yield from ([row] if curve.seeds is None else _by_seed(row, curve.seeds, place))


def _by_seed(
    row: dict[str, Any], seeds: Sequence[SeedAnswer], place: int
) -> Iterator[dict[str, Any]]:
    for seed in seeds:
        yield row | {"seed": seed.seed, "run": seed.run_id, "value": seed.values[place]}


def curves_json(sweep_id: str, comparison: Comparison, with_seeds: bool) -> bytes:
    """Return the JSON of a `CurvesAnswer`."""
    view = comparison.view
    document = {
        "sweep": sweep_id,
        "metric": view.metric,
        "normalized": view.normalized,
        "band": view.band,
        "x": view.x,
        "definition": definition([comparison]),
        "panels": [_panel(panel, with_seeds) for panel in comparison.panels],
    }
    return json.dumps(document, allow_nan=False, separators=(",", ":")).encode()


def _panel(panel: Panel, with_seeds: bool) -> Mapping[str, Any]:
    zero = panel.random_return
    return {
        "environment": panel.environment,
        "random_return": zero
        and {key: asdict(zero)[key] for key in RandomReturnAnswer.model_fields},
        "curves": [_curve(one, with_seeds) for one in panel.curves],
    }


def _curve(one: LabelledCurve, with_seeds: bool) -> Mapping[str, Any]:
    curve = one.curve
    document = {
        "algorithm": one.spec.algorithm,
        "weights": one.spec.weights._asdict(),
        "config": dict(one.spec.config),
        "label": one.label,
        "runs": len(one.seeds),
        "unfinished": one.unfinished,
        "x": as_whole(curve.x),
        "mean": numbers(curve.mean),
        "low": numbers(curve.low),
        "high": numbers(curve.high),
        "n": curve.n.tolist(),
    }
    if with_seeds:
        document["seeds"] = [
            {"seed": seed.seed, "run_id": seed.run_id, "values": numbers(seed.values)}
            for seed in one.seeds
        ]
    return document


def as_whole(x: Floats) -> list[int] | Numbers:
    """Return x [p] as whole numbers where they all are."""
    if all(value.is_integer() for value in x.tolist()):
        return [int(value) for value in x.tolist()]
    return numbers(x)
