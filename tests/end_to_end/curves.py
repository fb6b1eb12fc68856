"""What a sweep's runs have measured, to be compared bit for bit, and waiting for it."""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from service.client import Client

Curve = Mapping[str, Sequence[Any]]
Curves = dict[tuple[str, str, int], Curve]

END_SECONDS = 1800.0
POLL_SECONDS = 0.2  # whoever asks takes time from those who train


def curves_at_the_end(client: Client, sweep_id: str) -> Curves:
    """Everything that was measured but the time it took, once all runs have succeeded."""
    ended = client.wait(sweep_id, timeout_seconds=END_SECONDS)
    assert ended.runs.succeeded == ended.runs.total, ended
    curves: Curves = {}
    for run in client.runs(sweep_id):
        columns = client.measurements(run.id).columns
        assert list(columns["timestep"]) == list(range(800, run.timesteps + 1, 800))
        key = (run.label, run.environment, run.seed)
        curves[key] = without_times(columns)
    return curves


def without_times(columns: Curve) -> Curve:
    """Return the columns that are the same every time."""
    return {name: list(values) for name, values in columns.items() if "seconds" not in name}


def submitted(client: Client, request: dict[str, Any]) -> str:
    """A sweep's id, once every run of it trains."""
    sweep_id = client.submit(request).id
    wait_for(lambda: all(run.timestep >= 800 for run in client.runs(sweep_id)))
    return sweep_id


def wait_for(is_so: Callable[[], bool], seconds: float = END_SECONDS) -> None:
    """Wait until something is so; fails the test where it does not become so in time."""
    deadline = time.monotonic() + seconds
    while not is_so():
        assert time.monotonic() < deadline
        time.sleep(POLL_SECONDS)


def report(name: str, value: float, unit: str) -> None:
    """Print a figure."""
    print(f"{name}: {value:.3g} {unit}".rstrip())  # noqa: T201
