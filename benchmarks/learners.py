"""Learners: seed-updates per second on one core, compared with stable-baselines3 and JAX.

Networks have 64-64 units, batches 64 rows, states 14 numbers, actions 4. An update is one Adam step
of every network and of every target. Ours are timed in cycles of 50, with all of a cycle's learning
(drawing batches, adapting the noise, changing the value scale); those of stable-baselines3 as in
its `train` (its SAC, with a fixed temperature, has targets of both critics in place of V); JAX's as
in benchmarks/peers/jax_ddpg.py. Environment steps are not included for any of them. All are
measured in the same run, and the whole process is bound to one core. They take turns, round after
round, and the best round of each counts: other programs can only slow one down.

It also prints the rate of batched 64 x 64 products of float32 (the work of a hidden layer), and the
share of it that our updates reach, counting only their matrix products.

    python -m benchmarks.learners [--seconds 1]
"""

import argparse
import os
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import torch
from stable_baselines3 import DDPG, SAC
from stable_baselines3.common.logger import configure

from algorithms import catalogue
from algorithms.actor_critic.agent import Agent
from algorithms.experience.replay import Memory
from algorithms.experience.rollout import Experience
from algorithms.threads import one_thread
from benchmarks.peers import jax_ddpg
from physics.drawing import Drawing
from physics.environment import Environment, FloatArray
from physics.randomness import generator

STATE, ACTION, HIDDEN, BATCH = 14, 4, 64, 64
STORED, CYCLE = 10_000, 50
ROUNDS = 5
WEIGHTS = {
    "ddpg": (0.0, 0.0),
    "hybrid-ddpg": (0.1, 0.1),
    "sac": (0.0, 0.0),
    "hybrid-sac": (0.1, 0.1),
}

Learn = Callable[[], None]


class Sizes(Environment):
    """A task that is never stepped, with the sizes of the half cheetah."""

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
        """An empty drawing."""
        return Drawing(view=(0.0, 0.0, 1.0, 1.0), shapes=())


def fill_replay(agent: Agent, random: np.random.Generator, linearized: bool) -> None:
    """Store random transitions and, for a hybrid, derivatives in an agent's replay."""
    columns, rows = (STATE + ACTION, STORED) if linearized else (0, 0)

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


def our_cycle(name: str, seeds: int) -> Learn:
    """A cycle of updates of each of `seeds` runs."""
    algorithm, weights = catalogue.find(name), WEIGHTS[name]
    config = algorithm.config_class()(cycle_updates=CYCLE)
    agents = algorithm.load()(Sizes(), range(seeds), weights, STORED, config)._agents
    for agent in agents:
        fill_replay(agent, generator(agent.seed, "benchmark"), any(weights))

    def learn() -> None:
        with one_thread():
            for agent in agents:
                assert agent.learn() is None

    return learn


class PeerTask(gymnasium.Env[np.ndarray, np.ndarray]):
    """The same sizes for stable-baselines3."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (STATE,))
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (ACTION,))


def peer_cycle(peer: type[DDPG] | type[SAC], **settings: Any) -> Learn:
    """The same number of updates of a learner of stable-baselines3, for one run."""
    model = peer(
        "MlpPolicy",
        PeerTask(),
        batch_size=64,
        buffer_size=STORED,
        policy_kwargs={"net_arch": [64, 64]},
        train_freq=(100, "step"),
        device="cpu",
        **settings,
    )
    model.set_logger(configure(format_strings=[]))
    buffer, random = model.replay_buffer, generator(0, "benchmark")
    assert buffer is not None
    for _ in range(STORED):
        state, following = random.standard_normal((2, 1, STATE))
        action = random.uniform(-1.0, 1.0, (1, ACTION))
        buffer.add(state, following, action, np.ones(1), np.zeros(1), [{}])
    return lambda: model.train(gradient_steps=CYCLE, batch_size=64)


def product_cycle() -> Learn:
    """A cycle of calls of numpy, each with a stack of 16 products of 64 x 64 float32 matrices."""
    left, right = generator(0, "benchmark").standard_normal((2, 16, 64, 64)).astype(np.float32)
    result = np.empty_like(left)

    def multiply() -> None:
        for _ in range(CYCLE):
            np.matmul(left, right, out=result)

    return multiply


def pass_flops(inputs: int, outputs: int) -> int:
    """Floating point operations in the matrix products of a pass forward, or back to the inputs."""
    return 2 * BATCH * HIDDEN * (inputs + HIDDEN + outputs)


def product_flops(name: str) -> float:
    """Floating point operations in the matrix products of one update.

    A pass forward through a network is one product a layer, `2 B I H`, a pass back to its inputs
    another, and the gradient of its parameters a third; a second-order pass takes each twice.
    """
    return sac_flops(WEIGHTS[name]) if "sac" in name else ddpg_flops(WEIGHTS[name])


def sac_flops(weights: tuple[float, float]) -> float:
    """The operations of a target, the policy's loss (with both critics), V's, both critics'."""
    policy, value = pass_flops(STATE, 2 * ACTION), pass_flops(STATE, 1)
    critic = pass_flops(STATE + ACTION, 1)
    target, of_critics = value, 2 * 3 * critic
    if any(weights):
        target += value
        of_critics += 2 * 4 * critic
    return target + 3 * policy + 3 * critic + 3 * value + of_critics


def ddpg_flops(weights: tuple[float, float]) -> float:
    """The operations of a target, the critic's loss and the actor's."""
    actor, critic = pass_flops(STATE, ACTION), pass_flops(STATE + ACTION, 1)
    target, of_critic, of_actor = actor + critic, 3 * critic, 3 * actor + 2 * critic
    if any(weights):
        target += actor + critic
        of_critic += 4 * critic
    return target + of_critic + of_actor


def best_seconds(learns: dict[str, Learn], seconds: float) -> dict[str, float]:
    """The seconds per call of each in its best round; a round takes about `seconds`."""
    calls = {}
    for name, learn in learns.items():
        learn()
        start, calls[name] = time.perf_counter(), 0
        while time.perf_counter() - start < seconds:
            learn()
            calls[name] += 1
    best = dict.fromkeys(learns, np.inf)
    for _ in range(ROUNDS):
        for name, learn in learns.items():
            start = time.perf_counter()
            for _ in range(calls[name]):
                learn()
            best[name] = min(best[name], (time.perf_counter() - start) / calls[name])
    return best


def plural(seeds: int) -> str:
    return f"{seeds} seed{'s' * (seeds > 1)}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=1.0, help="length of a round")
    seconds = parser.parse_args().seconds
    torch.set_num_threads(1)
    learns = {
        "stable-baselines3 ddpg": peer_cycle(DDPG),
        "stable-baselines3 sac": peer_cycle(SAC, ent_coef=0.2),
        "products": product_cycle(),
    }
    for name, weights in WEIGHTS.items():
        for seeds in (1, 16):
            learns[f"{name}, {plural(seeds)}"] = our_cycle(name, seeds)
            if "ddpg" in name:
                learns[f"JAX {name}, {plural(seeds)}"] = jax_ddpg.cycle(
                    seeds, CYCLE, STATE, ACTION, STORED, weights
                )
    with one_thread():
        took = best_seconds(learns, seconds)
    product_rate = CYCLE * 16 * 2 * 64**3 / took["products"]
    print(f"batched products of 64 x 64: {product_rate / 1e9:.1f} GFLOP/s")
    for peer in ("ddpg", "sac"):
        peer_rate = CYCLE / took[f"stable-baselines3 {peer}"]
        print(f"stable-baselines3 {peer}, 1 seed: {peer_rate:.0f} seed-updates/s")
        for name in (peer, f"hybrid-{peer}"):
            for seeds in (1, 16):
                whose = f"{name}, {plural(seeds)}"
                rate = CYCLE * seeds / took[whose]
                share = rate * product_flops(name) / product_rate
                print(f"{whose}: {rate:.0f} seed-updates/s")
                print(f"{whose}, to stable-baselines3 {peer}: {rate / peer_rate:.2f} times")
                print(f"{whose}, of the products' rate: {100 * share:.0f} %")
                if f"JAX {whose}" in took:
                    theirs = CYCLE * seeds / took[f"JAX {whose}"]
                    print(f"JAX {whose}: {theirs:.0f} seed-updates/s")
                    print(f"{whose}, to JAX: {rate / theirs:.2f} times")


if __name__ == "__main__":
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # before JAX starts its threads
    main()
