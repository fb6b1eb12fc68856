"""The walk to an arm of one's own, from an empty folder: as its page says, but shorter."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import algorithms
from tests.docs.pages import ROOT, blocks, commands

PAGE = ROOT / "docs" / "walk-arm.md"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """With arm.py and nothing else."""
    (tmp_path / "arm.py").write_text(blocks(PAGE, "python")[0])
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "arm", raising=False)
    monkeypatch.setenv("MPLBACKEND", "agg")
    return tmp_path


def test_the_audit_passes(folder: Path) -> None:
    (call,) = (each for each in commands(PAGE) if each.startswith("python -m physics"))
    answer = subprocess.run(
        [sys.executable, *call.split()[1:], "--count", "20"],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "| free |" in answer.stdout


def test_both_learners_are_compared_and_the_policy_acts(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    train = algorithms.train

    def shortened(algorithm: str, task: Any, **_: Any) -> algorithms.Trainer:
        return train(algorithm, task, seeds=[0, 1], timesteps=800)

    monkeypatch.setattr(algorithms, "train", shortened)
    names: dict[str, Any] = {}
    for code in blocks(PAGE, "python")[1:]:
        exec(compile(code, PAGE, "exec"), names)  # noqa: S102
    names["plt"].close()
    printed = [line.split()[:3] for line in capsys.readouterr().out.splitlines()]
    learners = ("ddpg", "hybrid-ddpg")
    assert printed == [[name, seed, "800"] for name in learners for seed in ("0", "1")]
    assert (folder / "curve.png").stat().st_size > 0
    assert names["policy"].header.task == "Arm"
    assert names["states"].shape == (100, 4)
    assert np.isfinite(names["states"]).all()
    arm = names["arm"]
    assert arm.draw(names["states"][0]).rgb_array().ndim == 3
