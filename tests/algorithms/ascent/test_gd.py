"""GD: it climbs, it stops where it should, and its runs are blind to each other."""

import numpy as np
import pytest

import algorithms
import physics
from algorithms.ascent.gd import GDLearner
from algorithms.early_end import Divergence, EarlyEnd
from algorithms.experience.rollout import start_states
from algorithms.measurement import Measurement
from algorithms.planning.mpc import first_plans
from algorithms.settings import GDConfig
from physics.environment import BoolArray, FloatArray
from tests.algorithms.linear_quadratic import LinearQuadratic, differentiate_rows


def steep_rows(
    states: FloatArray,
    actions: FloatArray,
    next_states: FloatArray,
    rewards: FloatArray,
    terminated: BoolArray,
    state_jacobians: FloatArray,
    action_jacobians: FloatArray,
    reward_state_gradients: FloatArray,
    reward_action_gradients: FloatArray,
    reward_next_state_gradients: FloatArray,
) -> int:
    differentiate_rows(
        states, actions, next_states, rewards, terminated, state_jacobians, action_jacobians,
        reward_state_gradients, reward_action_gradients, reward_next_state_gradients,
    )  # fmt: skip
    action_jacobians[np.abs(states[:, 0]) > 500.0] = 1e300
    return -1


class Steep(LinearQuadratic):
    """Some episodes start on a cliff, the others never come near it."""

    differentiate_kernel = staticmethod(steep_rows)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return np.array([1e3 if generator.uniform() < 0.5 else 1.0, 0.0, 0.0])


def events(learner: GDLearner) -> list[Measurement | EarlyEnd]:
    found: list[Measurement | EarlyEnd] = []
    while not learner.finished:
        found += learner.advance()
    return found


def test_it_learns_to_balance_a_pole() -> None:
    measured = algorithms.train("gd", "CartPole", [0], None, 24_000, {"rate": 0.001})
    curve = [m.return_mean for m in measured]
    assert np.mean(curve[-5:]) > curve[0] + 50.0


def test_its_first_actor_is_that_of_the_other_learners() -> None:
    """The first episode is the one that MPC plans from."""
    task = physics.make("Pendulum")
    learner = GDLearner(task, [0, 3], 800, GDConfig())
    expected, _ = first_plans(task, [0, 3], 64)
    lived = learner._live()
    for seed, rewards in zip([0, 3], expected.rewards, strict=True):
        np.testing.assert_array_equal(lived[seed]().rewards[:, 0], rewards)


def test_episodes_that_end_early_cost_fewer_timesteps() -> None:
    learner = GDLearner(physics.make("CartPole"), [0, 1], 8_000, GDConfig(episodes=2))
    lived = learner._live()
    learner.advance()
    assert learner.timestep == min(int(lived[seed]().ends.sum()) for seed in (0, 1)) < 400


def test_a_gradient_that_is_not_finite_ends_its_run_alone() -> None:
    task, seeds = Steep(), range(8)
    learner = GDLearner(task, seeds, 800, GDConfig())
    starts, _ = start_states(task, [(seed, "episode", 0) for seed in seeds])
    on_cliff = [seed for seed in seeds if starts[seed, 0] > 500.0]
    said = learner.advance()
    assert said == [Divergence(seed, 20, 1, "actor gradient") for seed in on_cliff]
    assert learner.seeds == [seed for seed in seeds if seed not in on_cliff] != []


def test_a_plateau_ends_a_run() -> None:
    task = physics.make("MassPoint")
    found = events(GDLearner(task, [0], 400_000, GDConfig(rate=0.01, patience=12)))
    curve = [e.return_mean for e in found if isinstance(e, Measurement)]
    assert 13 <= len(curve) < 500
    means = [np.mean(curve[max(0, i - 9) : i + 1]) for i in range(len(curve))]
    assert len(curve) - 1 - int(np.argmax(means)) == 12


def test_what_a_run_has_learned_outlives_it() -> None:
    learner = GDLearner(physics.make("MassPoint"), [0, 1], 800, GDConfig())
    events(learner)
    assert learner.seeds == []
    assert learner.snapshot(1).timestep >= 800


def test_it_refuses_a_task_without_reward_gradient() -> None:
    with pytest.raises(ValueError, match=r"gd needs the reward's gradient, and that of Acrobot"):
        algorithms.build("gd", "Acrobot", [0])
