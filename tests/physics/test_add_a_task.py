"""docs/add-a-task.md, done: its module, its entry point, its audit."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import physics
from physics.environment import Environment
from physics.randomness import generator
from tests.docs.pages import ROOT, blocks
from tests.installed_package import install

PAGE = ROOT / "docs" / "add-a-task.md"


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (code,), (project,) = blocks(PAGE, "python"), blocks(PAGE, "toml")
    return install(tmp_path, "van_der_pol", code, project, monkeypatch)


@pytest.fixture
def environment(package: Path) -> Environment:
    return physics.make("VanDerPol")


@pytest.mark.usefixtures("package")
def test_it_is_listed_after_our_own() -> None:
    assert physics.names()[-1] == "VanDerPol"


def test_its_rows_do_not_feel_each_other(environment: Environment) -> None:
    states, actions = environment.sample(generator(0, "docs"), 70)
    whole = environment.differentiate(states, actions)
    for rows in (slice(0, 1), slice(69, 70), slice(5, 22), slice(None, None, -1)):
        part = environment.differentiate(states[rows], actions[rows])
        for one, other in zip(
            [*part.transition, *part[1:]], [*whole.transition, *whole[1:]], strict=True
        ):
            np.testing.assert_array_equal(one, other[rows])
    stepped = environment.step(states, actions)
    for one, other in zip(stepped, whole.transition, strict=True):
        np.testing.assert_array_equal(one, other)


def test_its_action_is_clipped(environment: Environment) -> None:
    states = np.zeros((3, 2))
    linearization = environment.differentiate(states, np.array([[1.0], [2.0], [-2.0]]))
    np.testing.assert_allclose(linearization.transition.next_state[:, 1], [0.1, 0.1, -0.1])
    np.testing.assert_allclose(linearization.action_jacobian[:, 1, 0], [0.1, 0.0, 0.0])
    np.testing.assert_allclose(linearization.reward_action_gradient[:, 0], [-0.02, 0.0, 0.0])


def test_the_file_alone_is_audited_and_trained_from_an_empty_folder(tmp_path: Path) -> None:
    (code,) = blocks(PAGE, "python")
    (tmp_path / "van_der_pol.py").write_text(code)
    (shown,) = [block for block in blocks(PAGE, "sh") if "algorithms" in block]
    for line in shown.splitlines():
        _, *arguments = line.split()
        shorter = ["--count", "20"] if "audit" in line else ["--timesteps", "800"]
        answer = subprocess.run(
            [sys.executable, *arguments, *shorter],
            capture_output=True,
            text=True,
            check=False,
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
        assert answer.returncode == 0, answer.stdout + answer.stderr
    rows = (tmp_path / "curves.csv").read_text().splitlines()
    assert [row.split(",")[:2] for row in rows[1:]] == [[str(seed), "800"] for seed in range(4)]


def test_the_command_audits_it(package: Path) -> None:
    answer = subprocess.run(
        [sys.executable, "-m", "physics", "audit", "VanDerPol", "--count", "40"],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": f"{package}{os.pathsep}{ROOT}"},
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "| VanDerPol | 1 | free |" in answer.stdout
    assert "| VanDerPol | 1 | clipped |" in answer.stdout
