"""The Grafana dashboard and Prometheus' rules ask for metrics that the service has."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from service.metrics import REGISTRY, PresentState
from service.model.run import RunStatus

FOLDER = Path(__file__).parents[2] / "docker" / "monitoring"
METRIC = re.compile(r"\bd3pg_\w+")


class Nothing:
    """An empty store."""

    def count_runs(self) -> dict[str, int]:
        return {}

    def count_attempts(self) -> dict[str, int]:
        return {}


def expressions() -> list[str]:
    board: dict[str, Any] = json.loads((FOLDER / "grafana-dashboard.json").read_text())
    rules: dict[str, Any] = yaml.safe_load((FOLDER / "alerts.yml").read_text())
    return [target["expr"] for panel in board["panels"] for target in panel["targets"]] + [
        rule["expr"] for group in rules["groups"] for rule in group["rules"]
    ]


@pytest.fixture(scope="module")
def metrics() -> set[str]:
    """Every name that /metrics can have."""
    noted = {sample.name for family in REGISTRY.collect() for sample in family.samples}
    noted |= {
        family.name + ending
        for family in REGISTRY.collect()
        if family.type == "histogram"
        for ending in ("_bucket", "_count", "_sum")
    }
    return noted | {family.name for family in PresentState(Nothing(), {}, 0).collect()}


def test_every_metric_that_is_asked_for_exists(metrics: set[str]) -> None:
    asked = {name for text in expressions() for name in METRIC.findall(text)}
    assert len(asked) >= 7
    assert asked <= metrics


def test_every_status_that_is_asked_for_exists() -> None:
    asked = {
        status
        for text in expressions()
        for group in re.findall(r'status[=!]~?"([a-z|]+)"', text)
        for status in group.split("|")
    }
    assert asked
    assert asked <= set(RunStatus)


def test_panels_do_not_overlap() -> None:
    board = json.loads((FOLDER / "grafana-dashboard.json").read_text())
    taken: set[tuple[int, int]] = set()
    for panel in board["panels"]:
        place = panel["gridPos"]
        cells = {
            (place["x"] + dx, place["y"] + dy)
            for dx in range(place["w"])
            for dy in range(place["h"])
        }
        assert not cells & taken
        assert place["x"] + place["w"] <= 24
        taken |= cells
