"""A user's script: a task in child processes, under the start method that is its argument."""

import sys
from typing import Any

import gymnasium
import numpy as np
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv

import physics

TASK = "d3pg/Pendulum-v0"
SEED = 5


def main(method: str) -> None:
    """Compare a child's episode with one of this process."""
    assert "Pendulum" in physics.names()
    alone = gymnasium.make(TASK)
    settings = {"start_method": method}
    vector: Any = make_vec_env(TASK, seed=SEED, vec_env_cls=SubprocVecEnv, vec_env_kwargs=settings)
    np.testing.assert_array_equal(vector.reset()[0], alone.reset(seed=SEED)[0])
    for _ in range(3):
        action = np.full((1, 1), 0.5, np.float32)
        np.testing.assert_array_equal(vector.step(action)[0][0], alone.step(action[0])[0])
    vector.close()


if __name__ == "__main__":
    main(sys.argv[1])
