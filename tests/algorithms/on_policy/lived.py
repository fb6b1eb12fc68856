"""A window of a run, and the same steps again in torch, float64."""

from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

import physics
from algorithms.networks.scaling import CLIP, Scaling
from algorithms.networks.shape import Shape
from algorithms.on_policy.run import Moment, WindowRun
from algorithms.on_policy.window import Window
from algorithms.on_policy.window_learner import WindowLearner
from physics.environment import Environment, FloatArray
from physics.randomness import generator
from tests.algorithms.plain import Plain, not_small

GAMMA, TRACE = 0.97, 0.9
SMALL: dict[str, Any] = {"hidden_units": 16, "gamma": GAMMA, "trace": TRACE, "clip": 1e9}


class Lived(NamedTuple):
    """A run about to learn from a window, values in a unit other than 1."""

    task: Environment
    run: WindowRun
    window: Window
    moment: Moment
    states: FloatArray
    """[T, E, n], that steps began with."""
    actions: FloatArray
    """[T, E, m]"""


def lived(name: str, learner: WindowLearner) -> Lived:
    """A second window: some episodes end in it by themselves or by time, others go on."""
    task, [run] = learner._environment, learner._runs
    random = generator(4, name)
    networks = run.networks
    m = task.action_size
    networks.actor.theta[:-m] = not_small(networks.actor_shape, random)
    networks.critic.theta[:] = not_small(networks.critic_shape, random)
    networks.critic.target[:] = not_small(networks.critic_shape, random)
    learner._live()
    run.episodes.elapsed[0] = task.horizon - 3
    if name == "CartPole":
        run.episodes.is_over[1] = False
        run.episodes.states[1] = 2.35, 2.0, 0.0, 0.0  # leaves the track, which ends the task
    states, _ = task.sample(random, 50)
    run._statistics.observe(task.features(states).astype(np.float32))
    run._statistics.set_value_scale(-3.0, 7.0)
    began: list[tuple[FloatArray, FloatArray]] = []
    call = task.differentiate if learner._linearized else task.step

    def noted(states: FloatArray, actions: FloatArray) -> object:
        began.append((states.copy(), actions.copy()))
        return call(states, actions)

    task.__dict__[call.__name__] = noted
    window = learner._live()[run.history.seed]()
    del task.__dict__[call.__name__]
    moment = Moment(0, 0.0, run._statistics.scaling(), generator(0, "batches"))
    return Lived(task, run, window, moment, *map(np.stack, zip(*began, strict=True)))


def normal(features: Tensor, scaling: Scaling) -> Tensor:
    mean, inverse = (torch.tensor(part, dtype=torch.float64) for part in scaling[:2])
    return torch.clip((features - mean) * inverse, -float(CLIP), float(CLIP))


def value(plain: Plain, features: Tensor, scaling: Scaling) -> Tensor:
    """V of features [..., F]."""
    rows = features.reshape(-1, features.shape[-1])
    v = plain(normal(rows, scaling))[:, 0].reshape(features.shape[:-1])
    return float(scaling.value_mean) + float(scaling.value_std) * v


def lambda_returns(window: Window, next_values: NDArray[np.float64]) -> NDArray[np.float64]:
    """TD(lambda)'s returns by their definition: a mean of n-step returns."""
    T, E = window.rewards.shape
    result = np.zeros((T, E))
    for e in range(E):
        for t in range(T):
            ahead = int(np.argmax(window.is_last[t:, e])) + 1
            earned, weight = 0.0, 1.0
            for n in range(1, ahead + 1):
                i = t + n - 1
                earned += GAMMA ** (n - 1) * window.rewards[i, e]
                rest = 0.0 if window.terminated[i, e] else GAMMA**n * next_values[i, e]
                share = weight if n == ahead else weight * (1 - TRACE)
                result[t, e] += share * (earned + rest)
                weight *= TRACE
    return result


def actor(theta: NDArray[np.float32], shape: Shape) -> tuple[Plain, Tensor]:
    """The network of the means, and log sigma."""
    log_sigma = torch.tensor(theta[-shape.outputs :], dtype=torch.float64, requires_grad=True)
    return Plain(theta[: -shape.outputs], shape), log_sigma


def step(task: Environment, states: Tensor, actions: Tensor) -> tuple[Tensor, Tensor]:
    transition = physics.torch_step(task, states, actions)
    return transition.next_state, transition.reward
