"""Gymnasium's classic tasks, one environment per row, under random actions."""

from collections.abc import Callable
from typing import Any

import gymnasium


def gymnasium_step(name: str, batch: int, mode: str) -> Callable[[], None]:
    """One step of `batch` environments of that name, with automatic resets."""
    peer: Any = gymnasium.make_vec(name, num_envs=batch, vectorization_mode=mode)
    peer.reset(seed=0)
    peer.action_space.seed(0)
    actions = [peer.action_space.sample() for _ in range(64)]
    turn = 0

    def step() -> None:
        nonlocal turn
        turn = (turn + 1) % 64
        peer.step(actions[turn])

    return step
