"""A trained policy acts as its run does: in numpy, in torch, from features and from states."""

import gymnasium
import numpy as np
import pytest
import torch
from numpy.typing import ArrayLike

import algorithms
import physics
from algorithms.acting.policy import policy_of
from tests.algorithms.acting.trained import SMALL, evaluated, learner_of, policy_by, untrained

ROUNDING = 2e-6  # of float32, through three layers, and of the learners' own tanh

CASES = [
    *((name, "Pendulum", {}) for name in SMALL),
    ("ddpg", "HalfCheetah", {"hidden_layers": 3, "hidden_units": 32, "activation": "elu"}),
    ("sac", "RollingDie", {"activation": "silu"}),
    ("td3", "CartPole", {"hidden_layers": 1, "activation": "relu"}),
    ("ddpg", "Pendulum(process_noise=0.1)", {}),
]


def assert_close(actions: ArrayLike, expected: ArrayLike) -> None:
    np.testing.assert_allclose(np.asarray(actions), np.asarray(expected), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(("name", "environment", "config"), CASES)
def test_numpy_torch_and_evaluation_agree(
    name: str, environment: str, config: dict[str, int | str]
) -> None:
    learner = learner_of(name, environment, config)
    policy, task = policy_by(learner, environment), physics.make(environment)
    states = np.random.default_rng(0).normal(scale=3.0, size=(200, task.state_size))
    features = task.features(states)
    actions = policy.act(features)
    assert actions.dtype == np.float32
    assert np.ptp(actions) > 0
    assert_close(actions, evaluated(learner, features))
    np.testing.assert_array_equal(policy.act_in(states), actions)
    assert_close(policy.act(features[7]), actions[7])
    assert_close(policy.act_in(states[7]), actions[7])
    of_features = algorithms.PolicyModule(policy)
    of_states = algorithms.PolicyModule(policy, takes="states")
    with torch.no_grad():
        assert_close(of_features(torch.tensor(features)), actions)
        assert_close(of_states(torch.tensor(states)), actions)


def test_a_policy_acts_on_what_it_is_given_whatever_the_noise_it_was_trained_with() -> None:
    environment = "Pendulum(observation_noise=0.1, process_noise=0.2)"
    policy = policy_by(learner_of("ddpg", environment), environment)
    state = physics.make(environment).initial_states([0])[0]
    exact = physics.make("Pendulum").features(state[None, :2])[0]
    np.testing.assert_array_equal(policy.act_in(state), policy.act(exact))
    given = policy.header.parameters
    assert (given["process_noise"], given["observation_noise"], given["mass"]) == (0.2, 0.1, 1.0)


def test_the_module_is_differentiable_and_draws_no_random_numbers() -> None:
    policy = policy_by(learner_of("ddpg", "Pendulum"), "Pendulum")
    before = torch.random.get_rng_state()
    module = algorithms.PolicyModule(policy, takes="states").double()
    assert torch.equal(torch.random.get_rng_state(), before)
    states = torch.tensor([[0.3, -0.2], [2.0, 1.0]], requires_grad=True, dtype=torch.float64)
    assert torch.autograd.gradcheck(module, states, atol=1e-6)
    assert len(list(module.parameters())) == 2 * 4 + 2


def test_it_acts_in_a_gymnasium_loop_as_evaluation_does() -> None:
    policy = policy_by(learner_of("ddpg", "Pendulum"), "Pendulum")
    env = gymnasium.make("d3pg/Pendulum-v0", jacobians=False)
    observation, _ = env.reset(seed=3)
    action = policy.act(observation)
    assert env.action_space.contains(action)
    by_state = policy.act_in(physics.make("Pendulum").initial_states([3])[0])
    np.testing.assert_array_equal(action, by_state)
    env.step(action)


@pytest.mark.parametrize(
    ("observation", "reason"),
    [
        (np.zeros(2), r"takes 3 features, \[3\] or \[batch, 3\], not \[2\]"),
        (np.zeros((2, 2, 3)), r"not \[2, 2, 3\]"),
        ([np.nan, 0.0, 0.0], "features that are NaN or infinite"),
    ],
)
def test_what_is_no_observation_is_refused(observation: np.ndarray, reason: str) -> None:
    policy = policy_by(learner_of("ddpg", "Pendulum"), "Pendulum")
    with pytest.raises(ValueError, match=f"of Pendulum .*{reason}"):
        policy.act(observation)


def test_what_is_no_state_is_refused() -> None:
    policy = policy_by(learner_of("ddpg", "Pendulum"), "Pendulum")
    with pytest.raises(ValueError, match=r"takes 2 coordinates, \[2\] or \[batch, 2\], not \[3\]"):
        policy.act_in(np.zeros(3))
    with pytest.raises(ValueError, match="'features' or 'states'"):
        algorithms.PolicyModule(policy, takes="images")  # type: ignore[arg-type]


@pytest.mark.parametrize("environment", physics.names())
def test_a_header_says_the_features_of_every_task(environment: str) -> None:
    task = physics.make(environment)
    states = np.random.default_rng(0).normal(scale=10.0, size=(40, task.state_size))
    header = policy_of(untrained(task), task, {}).header
    np.testing.assert_array_equal(header.feature_map.features(states), task.features(states))


def test_features_of_another_kind_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    task = physics.make("Pendulum")
    monkeypatch.setattr(type(task), "features", lambda self, states: np.zeros((len(states), 3)))
    with pytest.raises(ValueError, match="policy of Pendulum cannot be exported"):
        policy_of(untrained(task), task, {})


def test_it_says_what_it_is_of() -> None:
    learner = learner_of("ddpg", "Pendulum")
    snapshot = learner.snapshot(0)
    assert snapshot is not None
    policy = policy_of(snapshot, physics.make("Pendulum"), {"algorithm": "ddpg", "seed": 0})
    assert (policy.header.task, policy.header.task_version) == ("Pendulum", 1)
    assert policy.header.origin == {"algorithm": "ddpg", "seed": 0, "timestep": 100}
    assert policy.header.hidden_units == [64, 64]
    learner.advance()
    np.testing.assert_array_equal(policy.act(np.zeros(3)), policy.act(np.zeros(3)))
