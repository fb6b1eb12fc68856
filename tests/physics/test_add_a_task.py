"""docs/add-a-task.md, done: its module, its entry point, its audit."""

import importlib
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import physics
from physics.environment import Environment
from physics.randomness import generator

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "add-a-task.md"


def block(language: str) -> str:
    (found,) = re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(), re.DOTALL)
    return str(found)


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder as `pip install` leaves it: the module, and its metadata."""
    (tmp_path / "van_der_pol.py").write_text(block("python"))
    entries = tomllib.loads(block("toml"))["project"]["entry-points"]["d3pg.environments"]
    lines = ["[d3pg.environments]", *(f"{name} = {value}" for name, value in entries.items())]
    metadata = tmp_path / "van_der_pol-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: van-der-pol\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n")
    monkeypatch.syspath_prepend(tmp_path)
    importlib.invalidate_caches()
    monkeypatch.delitem(sys.modules, "van_der_pol", raising=False)
    return tmp_path


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
