"""Learners: seed-updates a second on one core, beside stable-baselines3's DDPG in the same run.

Networks 64-64, batch 64, state 14, action 4. An update is one Adam step of the critic, one of the
actor and both targets; ours are timed a cycle of 50 at a time, with all that a cycle does to learn
(drawing batches, adapting the noise, moving the value scale); stable-baselines3's as its `train`
does them. No environment steps are counted on either side. The best of several rounds counts: other
programs can only slow one down.

    python -m benchmarks.learners [--seconds 1]
"""

import argparse
import time
from collections.abc import Callable

import gymnasium
import numpy as np
import torch
from stable_baselines3 import DDPG
from stable_baselines3.common.logger import configure

from algorithms import catalogue
from algorithms.ddpg import DDPGAgent
from algorithms.losses import matching_of
from algorithms.replay import Memory
from algorithms.rollout import Experience
from algorithms.scaling import coordinates_of
from algorithms.threads import one_thread
from physics.drawing import Drawing
from physics.environment import Environment, FloatArray
from physics.randomness import generator

STATE, ACTION, STORED, CYCLE = 14, 4, 10_000, 50
ROUNDS = 5
WEIGHTS = {"ddpg": (0.0, 0.0), "hybrid-ddpg": (0.1, 0.1)}

Learn = Callable[[], None]


class Sizes(Environment):
    """A task with the sizes of the half cheetah that is never stepped."""

    name = "Sizes"
    version = 1
    state_size = STATE
    action_size = ACTION
    horizon = 200
    max_reward = 0.0

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """Any state."""
        return generator.standard_normal(STATE)

    def draw(self, state: FloatArray) -> Drawing:
        """Nothing to see."""
        return Drawing(view=(0.0, 0.0, 1.0, 1.0), shapes=())


def our_agent(seed: int, weights: tuple[float, float]) -> DDPGAgent:
    """A run with a replay full of random transitions and, for a hybrid, derivatives."""
    task = Sizes()
    config = catalogue.find("ddpg").config_class()()
    matching = matching_of(weights, by_cosine=False)
    agent = DDPGAgent(task, coordinates_of(task), seed, matching, STORED, config)
    random = generator(seed, "benchmark")
    columns = STATE + ACTION if any(weights) else 0
    rows = STORED if any(weights) else 0

    def numbers(*shape: int) -> np.ndarray:
        return random.standard_normal(shape).astype(np.float32)

    memory = Memory(
        features=numbers(STORED, STATE),
        actions=np.tanh(numbers(STORED, ACTION)),
        rewards=numbers(STORED),
        next_features=numbers(STORED, STATE),
        continues=np.ones(STORED, np.float32),
        reward_gradients=numbers(rows, columns),
        jacobians=numbers(rows, STATE, columns),
    )
    agent.remember(Experience(memory, random.standard_normal((STORED, STATE))))
    return agent


def our_cycle(name: str, seeds: int) -> Learn:
    """A cycle of updates of each of so many runs."""
    agents = [our_agent(seed, WEIGHTS[name]) for seed in range(seeds)]

    def learn() -> None:
        with one_thread():
            for agent in agents:
                assert agent.learn() is None

    return learn


class PeerTask(gymnasium.Env[np.ndarray, np.ndarray]):
    """The same sizes for stable-baselines3."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (STATE,))
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (ACTION,))


def peer_cycle() -> Learn:
    """As many updates of stable-baselines3's DDPG, of one run."""
    model = DDPG(
        "MlpPolicy",
        PeerTask(),
        batch_size=64,
        buffer_size=STORED,
        policy_kwargs={"net_arch": [64, 64]},
        train_freq=(100, "step"),
        device="cpu",
    )
    model.set_logger(configure(format_strings=[]))
    buffer, random = model.replay_buffer, generator(0, "benchmark")
    assert buffer is not None
    for _ in range(STORED):
        state, following = random.standard_normal((2, 1, STATE))
        action = random.uniform(-1.0, 1.0, (1, ACTION))
        buffer.add(state, following, action, np.ones(1), np.zeros(1), [{}])
    return lambda: model.train(gradient_steps=CYCLE, batch_size=64)


def best_rate(learn: Learn, updates: int, seconds: float) -> float:
    """Seed-updates a second of the best round, each of about `seconds`."""
    learn()
    start, calls = time.perf_counter(), 0
    while time.perf_counter() - start < seconds:
        learn()
        calls += 1
    durations = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for _ in range(calls):
            learn()
        durations.append(time.perf_counter() - start)
    return updates * calls / min(durations)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=1.0, help="of a round")
    seconds = parser.parse_args().seconds
    torch.set_num_threads(1)
    peer = best_rate(peer_cycle(), CYCLE, seconds)
    print(f"stable-baselines3 ddpg, 1 seed: {peer:.0f} seed-updates/s")
    for name in WEIGHTS:
        for seeds in (1, 16):
            rate = best_rate(our_cycle(name, seeds), CYCLE * seeds, seconds)
            print(f"{name}, {seeds} seed{'s' * (seeds > 1)}: {rate:.0f} seed-updates/s")
            print(f"{name}, {seeds} seed{'s' * (seeds > 1)}, to the peer: {rate / peer:.2f} times")


if __name__ == "__main__":
    main()
