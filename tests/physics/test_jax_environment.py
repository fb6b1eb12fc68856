"""Tasks of JAX functions: the numbers that torch gives, and what is said of mistakes."""

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import torch

from physics.audit.audit import audit
from physics.drawing import Drawing
from physics.environment import Environment, FloatArray
from physics.randomness import generator
from tests.physics.small_tasks import Plain

jax = pytest.importorskip("jax")

from physics.jax_engine import jnp  # noqa: E402
from physics.jax_environment import JaxEnvironment  # noqa: E402


class InJax(JaxEnvironment):
    """A driven pendulum, as `InTorch`."""

    name = "InJax"
    version = 1
    state_size = 2
    action_size = 1
    horizon = 60
    max_reward = 0.0

    def dynamics(self, state: Any, action: Any) -> Any:
        angle, speed = state
        speed = speed + 0.1 * (jnp.sin(angle) + 2.0 * action[0] - 0.1 * speed**3)
        return jnp.stack([angle + 0.1 * speed, speed])

    def reward(self, state: Any, action: Any, next_state: Any) -> Any:
        return -(next_state**2).sum() - state[0] * action[0]

    def terminated(self, next_state: Any) -> Any:
        return jnp.abs(next_state[0]) > 3.0

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return generator.uniform(-1.0, 1.0, 2)

    def draw(self, state: FloatArray) -> Drawing:
        return Plain.draw(self, state)  # type: ignore[arg-type]


class InTorch(Plain):
    """The same in torch."""

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        angle, speed = state
        speed = speed + 0.1 * (torch.sin(angle) + 2.0 * action[0] - 0.1 * speed**3)
        return torch.stack([angle + 0.1 * speed, speed])

    def reward(
        self, state: torch.Tensor, action: torch.Tensor, next_state: torch.Tensor
    ) -> torch.Tensor:
        return -(next_state**2).sum() - state[0] * action[0]

    def terminated(self, next_state: torch.Tensor) -> torch.Tensor:
        return next_state[0].abs() > 3.0


def rows(environment: Environment, count: int) -> tuple[FloatArray, FloatArray]:
    """States anywhere, and actions of which some are clipped."""
    random = generator(0, "jax")
    states = random.uniform(-3.0, 3.0, (count, environment.state_size))
    return states, random.uniform(-1.5, 1.5, (count, environment.action_size))


def test_all_numbers_are_those_of_torch() -> None:
    ours, theirs = InJax(), InTorch()
    found, expected = ours.differentiate(*rows(ours, 50)), theirs.differentiate(*rows(ours, 50))
    for one, other in zip(
        [*found.transition, *found[1:]], [*expected.transition, *expected[1:]], strict=True
    ):
        np.testing.assert_allclose(
            one.astype(np.float64), other.astype(np.float64), rtol=1e-12, atol=1e-13
        )
    assert 0 < found.transition.terminated.sum() < 50


def test_its_audit_passes() -> None:
    for row in audit(InJax(), count=200):
        assert row.passed(200), row


@pytest.mark.parametrize("count", [1, 15, 16, 17, 40])
def test_a_row_does_not_feel_the_others(count: int) -> None:
    environment = InJax()
    states, actions = rows(environment, 40)
    whole = environment.differentiate(states, actions)
    part = environment.differentiate(states[40 - count :], actions[40 - count :])
    for one, other in zip(
        [*whole.transition, *whole[1:]], [*part.transition, *part[1:]], strict=True
    ):
        np.testing.assert_array_equal(one[40 - count :], other)
    for one, other in zip(environment.step(states, actions), whole.transition, strict=True):
        np.testing.assert_array_equal(one, other)


def test_an_empty_batch_is_a_batch() -> None:
    environment = InJax()
    assert environment.differentiate(*rows(environment, 0)).state_jacobian.shape == (0, 2, 2)


class Looping(InJax):
    """A step that is a loop of a length that depends on the state, as a solver's."""

    def dynamics(self, state: Any, action: Any) -> Any:
        def step(carried: Any) -> Any:
            count, moved = carried
            return count + 1, moved + 0.01 * (action[0] - jnp.sin(moved))

        def going(carried: Any) -> Any:
            return carried[0] < 3 + jnp.abs(state[0]).astype(int)

        return jax.lax.while_loop(going, step, (0, state))[1]


def test_a_loop_of_unknown_length_is_differentiated() -> None:
    environment = Looping()
    states, actions = np.array([[0.3, 0.5], [2.5, -0.5]]), np.array([[0.2], [0.4]])
    found = environment.differentiate(states, actions).state_jacobian[:, 0, 0]
    near = [
        environment.step(states + np.array([side, 0.0]), actions).next_state[:, 0]
        for side in (1e-5, -1e-5)
    ]
    np.testing.assert_allclose(found, (near[0] - near[1]) / 2e-5, rtol=1e-8)


class Constant(InJax):
    """A reward that is the same in every step."""

    def reward(self, state: Any, action: Any, next_state: Any) -> Any:
        del state, action, next_state
        return -1.0


def test_a_constant_may_be_a_number() -> None:
    found = Constant().differentiate(*rows(InJax(), 5))
    assert found.transition.reward.tolist() == [-1.0] * 5
    assert not any(array.any() for array in found[3:])


class WithoutGradient(InJax):
    """A reward that is piecewise constant."""

    reward_is_differentiable = False

    def reward(self, state: Any, action: Any, next_state: Any) -> Any:
        del state, action
        return jnp.sign(next_state[0])


def test_a_reward_without_gradient_has_none() -> None:
    found = WithoutGradient().differentiate(*rows(InJax(), 5))
    assert not any(array.any() for array in found[3:])


def test_the_configuration_of_others_is_left_alone() -> None:
    environment = InJax()
    environment.step(*rows(environment, 3))
    assert jnp.ones(2).dtype == np.float32
    with jax.enable_x64(True):
        assert environment.step(*rows(environment, 3)).reward.dtype == np.float64


@pytest.mark.parametrize(
    ("attributes", "complaint"),
    [
        (
            {"dynamics": lambda self, s, a: s if s[0] > 0 else s + a},
            "dynamics cannot be compiled by JAX: use jax.numpy's functions .* instead of if",
        ),
        (
            {"dynamics": lambda self, s, a: np.asarray(s) + 1.0},
            r"dynamics cannot be compiled by JAX: .*no numpy",
        ),
        (
            {"dynamics": lambda self, s, a: s[:1]},
            r"dynamics must return an array \[2\] of float64, not \[1\] of float64",
        ),
        (
            {"dynamics": lambda self, s, a: s.astype(jnp.float32)},
            r"dynamics must return an array \[2\] of float64, not \[2\] of float32",
        ),
        ({"dynamics": lambda self, s, a: [s[0], s[1]]}, r"dynamics must return .* not list"),
        ({"dynamics": lambda self, s, a: s.reshape(3)}, "dynamics raised TypeError"),
        (
            {"reward": lambda self, s, a, n: n},
            r"reward must return an array \[\] of float64, not \[2\] of float64",
        ),
        ({"terminated": lambda self, n: n[0]}, r"terminated must return an array \[\] of bool"),
        ({"initial_state": lambda self, g: np.zeros(3)}, r"InJax: an initial state must be"),
    ],
)  # fmt: skip
def test_a_mistake_names_the_function(attributes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=rf"^Mistaken is not a valid task:\n- {complaint}"):
        type("Mistaken", (InJax,), attributes)()


def test_without_jax_a_sentence_says_what_to_install() -> None:
    code = (
        "import sys; sys.modules['jax'] = None\n"
        "try: import physics.jax_environment\n"
        "except ModuleNotFoundError as error: print(error)"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == (
        "tasks of JAX functions need the package jax: pip install 'd3pg[jax]'"
    )


def test_it_computes_on_one_thread() -> None:
    code = (
        "from tests.physics.test_jax_environment import InJax, rows\n"
        "import time\n"
        "task = InJax(); task.block = 4096; batch = rows(task, 4096); task.differentiate(*batch)\n"
        "wall, cores = time.perf_counter(), time.process_time()\n"
        "for _ in range(20): task.differentiate(*batch)\n"
        "print((time.process_time() - cores) / (time.perf_counter() - wall) < 1.2)"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == "True"
