"""Offline runs of Weights & Biases, written by its own client."""

from pathlib import Path

import pytest

from tests.service.export.measured import two_runs

wandb_runs = pytest.importorskip(
    "service.export.wandb_runs", reason="the extra `wandb` is not installed",
    exc_type=ModuleNotFoundError,
)  # fmt: skip


def test_each_run_is_an_offline_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert wandb_runs.write(two_runs(), tmp_path / "w", "small (3f9a)") == 2
    files = list((tmp_path / "w" / "wandb").glob("offline-run-*/run-*.wandb"))
    assert len(files) == 2
    contents = [file.read_bytes() for file in files]
    assert sorted(b"critic_loss" in each for each in contents) == [False, True]
    for name in (b"3f9a0c51b7de-0", b"3f9a0c51b7de-1"):
        assert sum(name in each for each in contents) == 1
    assert all(b"return_mean" in each and b"small (3f9a)" in each for each in contents)
