"""TensorBoard's event files, read back by the library that reads them."""

import math
from importlib import import_module
from pathlib import Path

import pytest

from tests.service.export.measured import two_runs

events = pytest.importorskip(
    "service.export.tensorboard_events", reason="the extra `tensorboard` is not installed",
    exc_type=ModuleNotFoundError,
)  # fmt: skip


def scalars(folder: Path) -> dict[str, list[tuple[int, float, float]]]:
    event_type = import_module("tensorboardX.proto.event_pb2").Event
    [file] = folder.iterdir()
    content = file.read_bytes()
    found: dict[str, list[tuple[int, float, float]]] = {}
    while content:
        length = int.from_bytes(content[:8], "little")
        event = event_type.FromString(content[12 : 12 + length])
        content = content[12 + length + 4 :]
        for value in event.summary.value:
            if value.WhichOneof("value") == "simple_value":
                found.setdefault(value.tag, []).append(
                    (event.step, event.wall_time, value.simple_value)
                )
    return found


def test_each_run_has_its_scalars_at_their_steps(tmp_path: Path) -> None:
    assert events.write(two_runs(), tmp_path, "small (3f9a)") == 2
    folder = tmp_path / "Pendulum(gravity=8)" / "ddpg noise=0.1"
    first = scalars(folder / "3f9a0c51b7de-0")
    assert first["return_mean"] == [(800, 0.8, -8.0), (1600, 1.6, -16.0), (2400, 2.4, -24.0)]
    assert math.isnan(first["critic_loss"][1][2])
    second = scalars(folder / "3f9a0c51b7de-1")
    assert [step for step, _, _ in second["return_mean"]] == [800, 1600]
    assert "critic_loss" not in second
