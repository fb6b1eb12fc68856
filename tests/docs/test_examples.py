"""The Python that a page shows runs as it stands, warnings being errors."""

import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

import algorithms
from algorithms.measurement import Measurement
from tests.docs.pages import PAGES, ROOT, blocks, name_of

AS_SHOWN = (
    "docs/diagnostics.md", "docs/gymnasium.md", "docs/jax.md", "docs/mujoco.md",
    "docs/policies.md", "docs/simulators.md",
)  # fmt: skip
SHORTENED = ("README.md", "docs/training.md")
ELSEWHERE = {
    "docs/add-a-learner.md": "tests/algorithms/test_add_a_learner.py",
    "docs/add-a-task.md": "tests/physics/test_add_a_task.py",
    "docs/client.md": "tests/service/client/test_client.py",
    "docs/walk-arm.md": "tests/docs/test_walks.py",
    "docs/walk-quadrotor.md": "tests/service/test_walk_quadrotor.py",
}


def test_every_page_with_python_is_run() -> None:
    with_python = {name_of(page) for page in PAGES if blocks(page, "python")}
    assert with_python == {*AS_SHOWN, *SHORTENED, *ELSEWHERE}
    for page, test in ELSEWHERE.items():
        assert Path(page).name in (ROOT / test).read_text()


@pytest.mark.parametrize("document", AS_SHOWN)
def test_what_a_page_shows_runs(document: str, tmp_path: Path) -> None:
    script = tmp_path / "shown.py"
    script.write_text("".join(blocks(ROOT / document, "python")))
    guide = blocks(ROOT / "docs" / "add-a-task.md", "python")  # its first is a file of a task
    (tmp_path / "van_der_pol.py").write_text(guide[0])
    answer = subprocess.run(
        [sys.executable, "-W", "error", script],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert answer.returncode == 0, answer.stderr


@pytest.mark.parametrize("document", SHORTENED)
def test_training_runs_for_fewer_seeds_and_timesteps(
    document: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    train = algorithms.train

    def shortened(
        algorithm: str, environment: str, seeds: Iterable[int], **options: Any
    ) -> Iterator[Measurement]:
        return train(algorithm, environment, list(seeds)[:2], **options, timesteps=800)

    monkeypatch.setattr(algorithms, "train", shortened, raising=False)
    shown = "".join(blocks(ROOT / document, "python"))
    exec(compile(shown, document, "exec"), {})  # noqa: S102
    assert [line.split()[:2] for line in capsys.readouterr().out.splitlines()] == [
        ["0", "800"],
        ["1", "800"],
    ]
