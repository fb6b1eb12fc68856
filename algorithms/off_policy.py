"""The off-policy loop: act, remember, learn, measure; for a cohort of runs.

A cycle takes some environment steps in every run, all runs together, and then lets one agent after
the other learn from its own replay. Every 800 timesteps each run is measured.
"""

import time
from collections import deque
from collections.abc import Collection, Mapping, Sequence
from typing import Protocol

import numpy as np

from algorithms.evaluation import episode_returns
from algorithms.measurement import HISTORY, MEASURE_EVERY, Divergence, Measurement
from algorithms.network import Shape
from algorithms.policy import Policies, Policy
from algorithms.replay import Replay
from algorithms.rollout import Experience, Rollout, start_states
from algorithms.snapshot import Snapshot
from algorithms.state import Saved, State, part, within
from algorithms.threads import one_thread
from physics.environment import Environment


class Agent(Protocol):
    """One run's learner."""

    seed: int
    updates: int
    jacobians: int
    replay: Replay

    def policy(self) -> Policy:
        """The deterministic policy learned so far."""

    def exploring_policy(self) -> Policy:
        """A policy to explore with, drawn anew at each call."""

    def remember(self, experience: Experience) -> None:
        """Take in what was lived through."""

    def learn(self) -> str | None:
        """Do a cycle's updates; return the name of a quantity that stopped being finite."""

    def diagnose(self, timestep: int) -> dict[str, float]:
        """Numbers that tell how learning went since the last call."""

    def state(self) -> State:
        """All that its next bits depend on but the replay."""

    def restore(self, state: State) -> None:
        """Take up what `state` gave; the replay is filled by who calls this."""

    def snapshot(self, timestep: int) -> Snapshot:
        """What was learned so far."""


class OffPolicyLearner:
    """A cohort of agents on one task; see `algorithms.learner.Learner`."""

    def __init__(
        self,
        environment: Environment,
        agents: Sequence[Agent],
        rollout: Rollout,
        actor_shape: Shape,
        *,
        timesteps: int,
        rollout_steps: int,
    ) -> None:
        """Bring together agents and the rollout that feeds them, seeds in the same order."""
        self._environment = environment
        self._agents = list(agents)
        self._rollout = rollout
        self._shape = actor_shape
        self._exploring = Policies([agent.exploring_policy() for agent in agents], actor_shape)
        self._timesteps = timesteps
        self._rollout_steps = rollout_steps
        self._histories = {agent.seed: deque[float](maxlen=HISTORY) for agent in agents}
        self._seconds = {agent.seed: 0.0 for agent in agents}
        self.timestep = 0

    @property
    def seeds(self) -> list[int]:
        """The seeds still in training."""
        return [agent.seed for agent in self._agents]

    @property
    def bytes_per_run(self) -> int:
        """The size of a replay when it is full."""
        return max((agent.replay.nbytes for agent in self._agents), default=0)

    @property
    def finished(self) -> bool:
        """Whether nothing is left to do."""
        return self.timestep >= self._timesteps or not self._agents

    def advance(self) -> list[Measurement | Divergence]:
        """Run one cycle."""
        start, runs = time.perf_counter(), len(self._agents)
        with one_thread():
            self._act()
            events: list[Measurement | Divergence] = [*self._learn()]
            measured = self._measure() if self.timestep % MEASURE_EVERY == 0 else []
        share = (time.perf_counter() - start) / runs
        for seed in self.seeds:
            self._seconds[seed] += share
        return events + [self._measurement(*each) for each in measured]

    def drop(self, seeds: Collection[int]) -> None:
        """Stop training these seeds."""
        rows = [row for row, agent in enumerate(self._agents) if agent.seed not in seeds]
        self._agents = [self._agents[row] for row in rows]
        self._rollout.keep(rows)
        self._exploring.keep(rows)

    def state(self, seed: int) -> State:
        """All that the run's next bits depend on but its journal."""
        k = self.seeds.index(seed)
        own = {
            "timestep": np.array(self.timestep),
            "seconds": np.array(self._seconds[seed]),
            "history": np.array(self._histories[seed], np.float64),
        }
        agent, rollout = self._agents[k].state(), self._rollout.state(k)
        return own | within("agent", agent) | within("rollout", rollout)

    def journal(self, seed: int, start: int) -> State:
        """States, actions and ends of the timesteps from `start` on that its replay still holds."""
        return self._agents[self.seeds.index(seed)].replay.journal(start)

    def restore(self, saved: Mapping[int, Saved]) -> None:
        """Take up every run where it was left, its replay worked out from its journal."""
        [self.timestep] = {int(saved[seed].state["timestep"]) for seed in self.seeds}
        for k, agent in enumerate(self._agents):
            state, journal = saved[agent.seed]
            self._seconds[agent.seed] = float(state["seconds"])
            self._histories[agent.seed].extend(state["history"].tolist())
            self._rollout.restore(k, part(state, "rollout"))
            agent.restore(part(state, "agent"))
            with one_thread():
                agent.replay.refill(self.timestep, journal, self._rollout.work_out)

    def snapshot(self, seed: int) -> Snapshot:
        """What the run has learned so far."""
        return self._agents[self.seeds.index(seed)].snapshot(self.timestep)

    def _act(self) -> None:
        """Take a cycle's steps, cut where a measurement is due."""
        due = MEASURE_EVERY - self.timestep % MEASURE_EVERY
        steps = min(self._rollout_steps, due, self._timesteps - self.timestep)
        for k in range(len(self._agents)):
            self._explore_anew(k)
        experiences = self._rollout.collect(steps, self._exploring, self._explore_anew)
        self.timestep += steps
        for agent, experience in zip(self._agents, experiences, strict=True):
            agent.remember(experience)

    def _explore_anew(self, k: int) -> None:
        self._exploring.set(k, self._agents[k].exploring_policy())

    def _learn(self) -> list[Divergence]:
        """Let every agent learn; those that diverge leave."""
        divergences = []
        for agent in self._agents:
            quantity = agent.learn()
            if quantity is not None:
                divergences.append(
                    Divergence(agent.seed, self.timestep, agent.updates + 1, quantity)
                )
        if divergences:
            self.drop({divergence.seed for divergence in divergences})
        return divergences

    def _measure(self) -> list[tuple[Agent, float, dict[str, float]]]:
        """Each agent with the return of an evaluation episode and its diagnostics."""
        if not self._agents:
            return []
        policies = Policies([agent.policy() for agent in self._agents], self._shape)
        index = self.timestep // MEASURE_EVERY
        starts = start_states(
            self._environment, [(seed, "evaluation", index) for seed in self.seeds]
        )
        returns = episode_returns(self._environment, policies, starts)
        return [
            (agent, float(value), agent.diagnose(self.timestep))
            for agent, value in zip(self._agents, returns, strict=True)
        ]

    def _measurement(
        self, agent: Agent, return_mean: float, diagnostics: dict[str, float]
    ) -> Measurement:
        history = self._histories[agent.seed]
        history.append(return_mean)
        return Measurement(
            seed=agent.seed,
            timestep=self.timestep,
            return_mean=return_mean,
            return_history=float(np.mean(history)),
            updates=agent.updates,
            jacobians=agent.jacobians,
            seconds=self._seconds[agent.seed],
            diagnostics=diagnostics,
        )
