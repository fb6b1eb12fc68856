"""SHAC: steps per second of an update, compared with a torch loop through `physics.torch_step`.

An update takes a window of 32 steps in 64 environments, computes the exact gradient of their return
and of the value at their end, steps the actor, and fits the critic in 16 epochs of 4 batches. The
torch loop is the usual way to write it: modules of the same sizes in float32, autograd through the
window, one thread. Windows with the actor's step are also measured separately, without the critic's
fit; there, torch is also measured with one environment at a time.

Ours are one run, and a cohort of 16, which shares the calls of the simulator. The process is bound
to one core; all take turns, and the processor time of the best round of each counts: other programs
can only slow one down.

    python -m benchmarks.short_horizon [TASK ...] [--rounds 5]
"""

import argparse
import os
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import torch
from torch import Tensor, nn

import algorithms
import physics
from algorithms.ascent.shac import BETAS, SHAC
from algorithms.on_policy.run import Moment
from algorithms.on_policy.window_learner import WindowLearner
from algorithms.settings import SHACConfig
from algorithms.threads import one_thread
from physics.randomness import generator

TASKS = ("Pendulum", "CartPole", "HalfCheetah")
CONFIG = SHACConfig()
SHAPE = {"environments": CONFIG.environments, "window": CONFIG.window}


class Ours:
    """A cohort of runs without an end."""

    def __init__(self, task: str, runs: int) -> None:
        """Begin."""
        learner = algorithms.build("shac", task, range(runs), timesteps=10**9, config=SHAPE)
        assert isinstance(learner, WindowLearner)
        self._learner = learner
        self._environment = physics.make(task)
        self.steps = runs * CONFIG.window * CONFIG.environments

    def update(self) -> None:
        """Do a whole update."""
        lived = self._learner._live()
        for run in self._learner._runs:
            window = lived[run.history.seed]()
            run.count(window)
            run.learn(window)

    def actor(self) -> None:
        """The window and the actor's step."""
        rule, lived = SHAC(self._environment, CONFIG), self._learner._live()
        for run in self._learner._runs:
            scaling = run._statistics.scaling()
            window = lived[run.history.seed]()
            outlook = rule.look_ahead(run.networks, window, scaling)
            moment = Moment(run.updates, 0.0, scaling, generator(0, "batches"))
            rule._climb(run.networks, window, moment, outlook.beyond)


def module(inputs: int, outputs: int) -> nn.Sequential:
    """A network with the structure of ours."""
    layers: list[nn.Module] = []
    for _ in range(CONFIG.hidden_layers):
        layers += [
            nn.Linear(inputs, CONFIG.hidden_units),
            nn.LayerNorm(CONFIG.hidden_units),
            nn.ELU(),
        ]
        inputs = CONFIG.hidden_units
    return nn.Sequential(*layers, nn.Linear(inputs, outputs))


class Torch:
    """The same loop in torch."""

    def __init__(self, task: str, environments: int) -> None:
        """Draw the networks."""
        self._task = physics.make(task)
        features, m = self._task.feature_size, self._task.action_size
        self._pi, self._v, self._target = (
            module(features, m),
            module(features, 1),
            module(features, 1),
        )
        self._log_sigma = nn.Parameter(torch.full((m,), -1.0))
        parameters = [*self._pi.parameters(), self._log_sigma]
        rate = {"betas": tuple(BETAS), "lr": CONFIG.actor_rate}
        self._pi_adam: Any = torch.optim.Adam(parameters, **rate)  # type: ignore[arg-type]
        self._v_adam: Any = torch.optim.Adam(self._v.parameters(), **rate)  # type: ignore[arg-type]
        self._parameters = parameters
        self._starts = self._task.initial_states(range(environments))
        self._state = torch.from_numpy(self._starts)
        self._elapsed = 0
        self.steps = CONFIG.window * environments

    def actor(self) -> tuple[Tensor, Tensor]:
        """The window and the actor's step; return the features and the targets of values."""
        state, total = self._state.detach(), torch.zeros(())
        weight = torch.ones(len(self._starts))
        seen, rewards, values, ends = [], [], [], []
        for t in range(CONFIG.window):
            features = self._task.features(state).float()
            mean = self._pi(features)
            action = torch.tanh(mean + self._log_sigma.exp() * torch.randn_like(mean))
            state, reward, terminated = physics.torch_step(self._task, state, action.double())
            self._elapsed += 1
            over = terminated | (self._elapsed % self._task.horizon == 0)
            worth = self._target(self._task.features(state).float())[:, 0]
            worth = torch.where(terminated, 0.0, worth)
            ending = over | (t == CONFIG.window - 1)
            total = total + (weight * (reward + CONFIG.gamma * ending * worth)).sum()
            weight = torch.where(over, 1.0, CONFIG.gamma * weight)
            state = torch.where(over[:, None], torch.from_numpy(self._starts), state)
            seen.append(features.detach())
            rewards.append(reward.detach().float())
            values.append(worth.detach())
            ends.append(ending)
        self._state = state
        self._step(self._pi_adam, -total / self.steps, self._parameters)
        later, targets = torch.zeros(len(self._starts)), []
        for reward, worth, end in zip(rewards[::-1], values[::-1], ends[::-1], strict=True):
            mixed = (1 - CONFIG.trace) * worth + CONFIG.trace * later
            later = reward + CONFIG.gamma * torch.where(end, worth, mixed)
            targets.append(later)
        return torch.cat(seen), torch.cat(targets[::-1])

    def update(self) -> None:
        """Do a whole update."""
        x, y = self.actor()
        for _ in range(CONFIG.critic_epochs):
            for rows in torch.randperm(self.steps).chunk(CONFIG.critic_batches):
                loss = ((self._v(x[rows])[:, 0] - y[rows]) ** 2).mean()
                self._step(self._v_adam, loss, list(self._v.parameters()))
        with torch.no_grad():
            for mine, theirs in zip(self._target.parameters(), self._v.parameters(), strict=True):
                mine.lerp_(theirs, 1 - CONFIG.target_share)

    def _step(self, adam: Any, loss: Tensor, parameters: list[nn.Parameter]) -> None:
        adam.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(parameters, CONFIG.clip)
        adam.step()


class Contender(NamedTuple):
    """A function, and the number of environment steps of a call."""

    name: str
    call: Callable[[], object]
    steps: int


def best_rates(contenders: Sequence[Contender], rounds: int) -> list[float]:
    """Steps per second of processor time in the best round of each, without the first round."""
    best = [float("inf")] * len(contenders)
    for contender in contenders:
        contender.call()
    for _ in range(rounds):
        for index, contender in enumerate(contenders):
            begun = time.process_time()
            contender.call()
            best[index] = min(best[index], time.process_time() - begun)
    return [each.steps / seconds for each, seconds in zip(contenders, best, strict=True)]


def compare(task: str, rounds: int) -> None:
    """Print the rates of all contenders on one task."""
    alone, cohort = Ours(task, 1), Ours(task, 16)
    batched, single = Torch(task, CONFIG.environments), Torch(task, 1)
    tables = {
        "whole updates": [
            Contender("a run alone", alone.update, alone.steps),
            Contender("a cohort of 16", cohort.update, cohort.steps),
            Contender("torch's loop", batched.update, batched.steps),
        ],
        "windows and the actor's step": [
            Contender("a run alone", alone.actor, alone.steps),
            Contender("a cohort of 16", cohort.actor, cohort.steps),
            Contender("torch's loop", batched.actor, batched.steps),
            Contender("torch's loop, one environment at a time", single.actor, single.steps),
        ],
    }
    for what, contenders in tables.items():
        print(f"{task}, {what}, steps a second:")
        rates = best_rates(contenders, rounds)
        for contender, rate in zip(contenders, rates, strict=True):
            print(f"    {contender.name}: {rate:,.0f} (a run alone: {rates[0] / rate:.1f} times)")


def main() -> None:
    """Measure the tasks named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", default=TASKS)
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    torch.set_num_threads(1)
    with one_thread():
        for task in arguments.tasks:
            compare(task, arguments.rounds)


if __name__ == "__main__":
    main()
