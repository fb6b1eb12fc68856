"""The exact gradient is unbiased on a smooth task, and blind to a jump."""

import numpy as np
import pytest

import physics
from algorithms.diagnostics.smoothing import Smoothing, compared, smoothing
from physics.environment import BoolArray, FloatArray
from physics.randomness import generator
from tests.algorithms.linear_quadratic import COST, FB, LinearQuadratic
from tests.algorithms.probes import Probe

GAIN = np.array([[-0.1, 0.0, 0.05], [0.0, -0.1, 0.0]])


def linear(states: FloatArray) -> tuple[FloatArray, FloatArray]:
    return states @ GAIN.T, np.repeat(GAIN[None], len(states), axis=0)


class Cliff(Probe):
    """One step that earns 1 beyond a = .1: only noise can tell."""

    name = "Cliff"
    state_size = 1
    horizon = 1

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return np.zeros(1)

    def answer(self, s: FloatArray) -> FloatArray:
        return np.ones_like(s)

    def advance(
        self, s: FloatArray, a: FloatArray, n: FloatArray, r: FloatArray, terminated: BoolArray
    ) -> None:
        n[:], r[:], terminated[:] = s, a[:, 0] > 0.1, True

    def slopes(self, s: FloatArray, a: FloatArray, n: FloatArray, *derivatives: FloatArray) -> None:
        derivatives[0][:] = 1.0


def quadratic_gradient(states: FloatArray, horizon: int) -> FloatArray:
    """The gradient of minus the closed loop's cost in its first action, from the value matrix."""
    value, step = np.zeros((3, 3)), np.vstack([np.eye(3), GAIN])
    for _ in range(horizon - 1):
        value = step.T @ (COST + FB.T @ value @ FB) @ step
    by_both: FloatArray = -np.hstack([states, states @ GAIN.T]) @ (COST + FB.T @ value @ FB)
    return by_both[:, 3:]


@pytest.fixture(scope="module")
def estimates() -> dict[int, Smoothing]:
    found = smoothing(LinearQuadratic(), linear, states(), (1, 4, 8), 0.05, pairs=200, seed=3)
    return {each.horizon: each for each in found}


def states() -> FloatArray:
    return generator(0, "states").uniform(-1.0, 1.0, (12, 3))


@pytest.mark.parametrize("horizon", [1, 4, 8])
def test_on_a_linear_quadratic_task_both_agree_with_the_riccati_gradient(
    estimates: dict[int, Smoothing], horizon: int
) -> None:
    each = estimates[horizon]
    known = np.sqrt(np.square(quadratic_gradient(states(), horizon)).sum(axis=1).mean())
    assert each.norm == pytest.approx(known, rel=0.05)
    assert each.bias < each.resolution
    assert each.resolution < 0.2 * each.norm
    assert each.exact_std < each.zeroth_std


def test_at_a_jump_the_exact_gradient_lacks_all_of_the_smoothed_one() -> None:
    noise = 0.2
    [each] = smoothing(
        Cliff(), lambda s: (np.zeros((len(s), 1)), np.zeros((len(s), 1, 1))), np.zeros((4, 1)),
        [1], noise, pairs=4000, seed=0,
    )  # fmt: skip
    density = np.exp(-((0.1 / noise) ** 2) / 2) / np.sqrt(2 * np.pi) / noise
    assert each.exact_std == 0.0
    assert each.norm == pytest.approx(density, rel=0.05)
    assert each.bias == pytest.approx(density, rel=0.05)


def thrown(push: tuple[float, float]) -> Smoothing:
    """Of a ball that the same push drives all the time."""
    task = physics.make("BallWall")

    def pushing(states: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.tile(push, (len(states), 1)), np.zeros((len(states), 2, 4))

    [each] = smoothing(task, pushing, task.initial_states([0]), [32], 0.2, pairs=100, seed=0)
    return each


def test_the_exact_gradient_is_noisy_where_a_throw_may_touch_the_wall() -> None:
    touching, above = thrown((0.4, 0.4)), thrown((0.4, 1.0))
    assert touching.exact_std > 5 * above.exact_std
    assert touching.exact_std > touching.zeroth_std / 2
    assert above.exact_std < above.zeroth_std / 5


def test_numbers_of_known_estimates() -> None:
    exact = np.array([[[1.0], [3.0]]])
    zeroth = np.array([[[-2.0], [-2.0]]])
    each = compared(4, 0.2, exact, zeroth)
    assert each == Smoothing(
        4, 0.2, norm=2.0, bias=np.sqrt(15.0), resolution=1.0, exact_std=np.sqrt(2.0), zeroth_std=0.0
    )


def test_the_same_seed_gives_the_same_numbers() -> None:
    def found(seed: int) -> list[Smoothing]:
        return smoothing(LinearQuadratic(), linear, states(), (2,), 0.2, pairs=4, seed=seed)

    assert found(1) == found(1)
    assert found(1) != found(2)
