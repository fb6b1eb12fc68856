"""The hybrids' target gradient is the derivative of the target, through the real simulator."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from torch import Tensor

from algorithms.actor_critic import ddpg_update, sac_update
from algorithms.networks.network import Shape
from algorithms.networks.optimizer import learned
from tests.algorithms.actor_critic.test_sac_update import RATES, SCALE, networks_in, shapes_in
from tests.algorithms.plain import GAMMA, Plain, PlainBatch, Setting, not_small, setting

ROWS, STEP = 64, 1e-5

Following = Callable[[Tensor], Tensor]


def by_differences(
    where: Setting, following: Following, reward_scale: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Central differences [ROWS, C + m] of the normalised target, and which rows have no kink."""
    task, scaling, batch = where.task, where.scaling, PlainBatch(where, np.arange(ROWS))
    states, actions = where.states[:ROWS], where.actions[:ROWS]
    seen = where.coordinates.seen
    goes_on = where.memory.continues[:ROWS].astype(np.float64)
    smooth = np.ones(ROWS, np.bool_)
    here = task.pieces(states, actions).piece
    columns = []
    for j in range(len(seen) + task.action_size):
        sides = []
        for sign in (1, -1):
            s, a = states.copy(), actions.copy()
            if j < len(seen):
                s[:, seen[j]] += sign * STEP
            else:
                a[:, j - len(seen)] += sign * STEP
            beyond = task.outside(s)
            s[beyond] = states[beyond]
            smooth &= ~beyond & (task.pieces(s, a).piece == here).all(axis=1)
            transition = task.step(s, a)
            x = batch.normal(torch.tensor(task.features(transition.next_state)))
            v = scaling.value_mean + scaling.value_std * following(x).detach().numpy()
            sides.append(reward_scale * transition.reward + GAMMA * goes_on * v)
            smooth &= (x.abs() < 5).all(1).numpy()
        columns.append((sides[0] - sides[1]) / (2 * STEP))
    return np.stack(columns, 1) * scaling.unit / scaling.value_std, smooth


def assert_derivative(
    where: Setting, target: NDArray[np.float32], following: Following, reward_scale: float = 1.0
) -> None:
    expected, smooth = by_differences(where, following, reward_scale)
    assert smooth.mean() > 0.5
    sizes = 1 + np.linalg.norm(expected, axis=1, keepdims=True)
    difference = np.abs(target[:ROWS] - expected) / sizes
    assert difference[smooth].max() < 1e-3


TASKS = ["Pendulum", "CartPole", "Acrobot", "RollingDie"]


@pytest.mark.parametrize("name", TASKS)
def test_of_ddpg(name: str) -> None:
    where = setting(name)
    inputs, m = where.task.feature_size, where.task.action_size
    shapes = Shape(inputs, (16, 16), m), Shape(inputs + m, (16, 16), 1)
    actor, critic = (learned(not_small(shape, where.random)) for shape in shapes)
    pi, q = Plain(actor.target, shapes[0]), Plain(critic.target, shapes[1])
    _, target = ddpg_update.gradient_pair(
        actor, critic, where.memory, where.coordinates, where.scaling, np.float32(GAMMA), shapes
    )
    assert_derivative(where, target, lambda x: q(torch.cat([x, torch.tanh(pi(x))], 1))[:, 0])


@pytest.mark.parametrize("name", TASKS)
def test_of_sac(name: str) -> None:
    where = setting(name)
    shapes = shapes_in(where)
    networks = networks_in(where, shapes)
    v = Plain(networks.value.target, shapes.value)
    _, target = sac_update.gradient_pair(
        networks, where.memory, where.coordinates, where.scaling, RATES, shapes
    )
    assert_derivative(where, target, lambda x: v(x)[:, 0], SCALE)
