"""The audit: what it counts, what it finds, and the record it keeps."""

import re

import numpy as np
import pytest
import torch

import physics
from physics.__main__ import main
from physics.audit.audit import audit
from physics.audit.notes import failures, notes
from physics.environment import FloatArray, Linearization, Pieces
from physics.tasks.mountain_car import MountainCar
from physics.tasks.pendulum import Pendulum
from tests.physics.small_tasks import DistanceAtGoal, LogOfNegative, Plain


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


@pytest.mark.parametrize("rounding", [3.99e-13, 4e-13])
def test_the_greatest_rounding_that_a_task_may_have_is_audited(rounding: float) -> None:
    class Rough(Pendulum):
        pass

    Rough.rounding = rounding
    assert all(row.passed(50) for row in audit(Rough(), count=50))
    Rough.rounding = 1.01 * 4e-13
    with pytest.raises(ValueError, match="rounding must be a number above 0, at most 4e-13"):
        Rough()


def test_a_wrong_derivative_fails_in_its_regime_alone() -> None:
    free, clipped, wall = audit(WrongAtTheWall(), count=100)
    assert free.passed(100)
    assert clipped.passed(100)
    assert not wall.passed(100)
    assert wall.worst >= 0.5


def test_states_at_a_kink_are_counted_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("physics.audit.audit._MOST_CHUNKS", 2)
    rows = audit(AlwaysAtAKink(), count=100)
    assert sum(row.states for row in rows) == 0
    assert 2 * 100 <= sum(row.kinks for row in rows) <= 2 * 500
    assert not any(row.passed(100) for row in rows)


class Silent(MountainCar):
    """Has no number for a derivative, once in a while, and does not say so."""

    value = np.nan

    def differentiate(self, states: FloatArray, actions: FloatArray) -> Linearization:
        linearization = super().differentiate(states, actions)
        linearization.state_jacobian[::7, 0, 1] = self.value
        return linearization


class HiddenClamp(Plain):
    """A speed limit that `pieces` does not declare, and that random actions never reach."""

    name = "HiddenClamp"

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        speed = (state[1] + 0.1 * action[0]).clamp(-8.0, 8.0)
        return torch.stack([state[0] + 0.1 * speed, speed])


class AtTheCorner(Plain):
    """Every state lies on an undeclared kink, where a central difference tells a mean."""

    name = "AtTheCorner"

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        return torch.stack([state[0].clamp(min=0.0), state[1] + 0.1 * action[0]])

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        states, actions = super().sample(generator, count)
        states[:, 0] = 0.0
        return states, actions


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_no_number_is_a_failure(value: float) -> None:
    task = Silent()
    task.value = value
    rows = audit(task, count=100)
    assert not any(row.passed(100) for row in rows)
    assert all(row.worst == np.inf for row in rows)
    assert all(row.median < 1e-6 for row in rows)


@pytest.mark.parametrize("task", [DistanceAtGoal, LogOfNegative])
def test_a_step_that_leaves_the_numbers_is_a_failure(task: type[Plain]) -> None:
    rows = audit(task(), count=100)
    assert rows[0].worst == np.inf
    assert not rows[0].passed(100)
    assert failures(rows, 100)[0] == (
        f"NOT PASSED: {task.name}, free: a step, a derivative or a difference is NaN or infinite"
    )


def test_a_kink_that_is_not_declared_is_reported() -> None:
    task = HiddenClamp()
    rows = audit(task, count=1000)
    assert all(row.passed(1000) for row in rows)
    assert sum(row.undeclared for row in rows) > 0
    told = "\n".join(notes(task, rows))
    assert re.search(
        r"NOTE: HiddenClamp: \d+ states have a kink nearby that `pieces` does not", told
    )
    assert re.search(r"cannot be known\. The states went .*, from -8 to 8 in s\[1\]", told)


def test_a_declared_kink_that_was_not_sampled_is_reported() -> None:
    class Declared(HiddenClamp):
        def pieces(self, states: FloatArray, actions: FloatArray) -> Pieces:
            base = super().pieces(states, actions)
            far = (np.abs(states[:, :1]) > 1000.0).astype(np.int64)
            return Pieces(base.regime, np.concatenate([base.piece, far], axis=1))

    assert notes(Declared(), []) == [
        "NOTE: HiddenClamp: over 1,000 states the columns [1] of `pieces` never changed: the kinks "
        "that they declare were not sampled."
    ]


def test_a_regime_without_a_name_is_a_failure() -> None:
    class Nameless(Plain):
        regimes = ("everywhere",)

    assert (
        "NOT PASSED: Plain: `pieces` returns the regimes [1], but `regimes` has names for 0 to 0"
        in notes(Nameless(), [])
    )


def test_a_state_on_an_undeclared_kink_is_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("physics.audit.audit._MOST_CHUNKS", 2)
    rows = audit(AtTheCorner(), count=100)
    assert [row.states for row in rows] == [0, 0]
    assert all(row.undeclared == row.kinks > 0 for row in rows)


@pytest.mark.parametrize("name", ["Pendulum", "MountainCar", "CartPole", "MassPoint"])
def test_declared_kinks_and_curvature_are_no_undeclared_ones(name: str) -> None:
    task = physics.make(name)
    rows = audit(task, count=500)
    assert sum(row.undeclared for row in rows) == 0
    assert len(notes(task, rows)) == (name in {"MassPoint", "CartPole"})


def test_a_regime_that_was_never_sampled_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("physics.audit.audit._MOST_CHUNKS", 2)

    class Timid(MountainCar):
        def sample(
            self, generator: np.random.Generator, count: int
        ) -> tuple[FloatArray, FloatArray]:
            return np.zeros((count, 2)), generator.uniform(-0.5, 0.5, (count, 1))

    assert failures(audit(Timid(), count=100), 100) == [
        "NOT PASSED: MountainCar, clipped: never sampled; let the task's `sample` go there",
        "NOT PASSED: MountainCar, wall: never sampled; let the task's `sample` go there",
    ]


def test_the_command_fails_on_no_number(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["physics", "audit", "DistanceAtGoal", "--count", "50"])
    monkeypatch.setattr("physics.__main__.as_task", lambda name: DistanceAtGoal())
    assert main() == 1
    printed = capsys.readouterr().out
    assert re.search(r"\| DistanceAtGoal \| 1 \| free \| \d+ \| \d+ \| inf \|", printed)
    assert "NOT PASSED: DistanceAtGoal, free: " in printed


def test_the_command_refuses_a_name_in_a_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["physics", "audit", "Pendullum"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert "error: unknown environment 'Pendullum'; did you mean" in capsys.readouterr().err


def test_the_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["physics", "audit", "MassPoint", "--count", "50"])
    assert main() == 0
    printed = capsys.readouterr().out
    assert "kernels of MassPoint: " in printed
    assert "| MassPoint | 1 | clipped |" in printed
    monkeypatch.setattr("sys.argv", ["physics", "compile", "MassPoint", "Pendulum"])
    assert main() == 0
    assert "kernels of Pendulum: " in capsys.readouterr().out
