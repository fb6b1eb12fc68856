"""The audit: what it counts, what it finds, and the record it keeps."""

import numpy as np
import pytest

import physics
from physics.__main__ import main
from physics.audit import audit
from physics.environment import FloatArray, Linearization
from physics.mountain_car import MountainCar
from physics.pendulum import Pendulum


class WrongAtTheWall(MountainCar):
    """Forgets that a wall stops the car, as a naive derivative does."""

    def differentiate(self, states: FloatArray, actions: FloatArray) -> Linearization:
        linearization = super().differentiate(states, actions)
        stopped = ~linearization.state_jacobian[:, 0].any(axis=1)
        linearization.state_jacobian[stopped, 0] = [1.0, 1.0]
        return linearization


class AlwaysAtAKink(Pendulum):
    """Stands on the edge of its torque's bound, where no derivative exists."""

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        states, actions = super().sample(generator, count)
        return states, np.sign(actions)


def test_a_right_task_passes() -> None:
    rows = audit(physics.make("MountainCar"), count=100)
    assert [row.regime for row in rows] == ["free", "clipped", "wall"]
    assert all(row.passed(100) for row in rows)
    assert all(0.0 < row.median <= row.worst < 1e-6 for row in rows[:2])


def test_a_wrong_derivative_fails_in_its_regime_alone() -> None:
    free, clipped, wall = audit(WrongAtTheWall(), count=100)
    assert free.passed(100)
    assert clipped.passed(100)
    assert not wall.passed(100)
    assert wall.worst >= 0.5


def test_states_at_a_kink_are_counted_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("physics.audit._MOST_CHUNKS", 2)
    rows = audit(AlwaysAtAKink(), count=100)
    assert sum(row.states for row in rows) == 0
    assert sum(row.kinks for row in rows) == 1000
    assert not any(row.passed(100) for row in rows)


def test_the_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["physics", "audit", "MassPoint", "--count", "50"])
    assert main() == 0
    printed = capsys.readouterr().out
    assert "kernels of MassPoint: " in printed
    assert "| MassPoint | 1 | clipped |" in printed
    monkeypatch.setattr("sys.argv", ["physics", "compile", "MassPoint", "Pendulum"])
    assert main() == 0
    assert "kernels of Pendulum: " in capsys.readouterr().out
