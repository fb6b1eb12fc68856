"""The off-policy loop: act, remember, learn, measure; for a cohort of runs.

A cycle takes some environment steps in every run, all runs together, and then lets one agent after
the other learn from its own replay. Every 800 timesteps, and at its end, each run is measured. An
error in one run ends that run alone.
"""

import math
from collections import deque
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TypeVar

import numpy as np

from algorithms.actor_critic.agent import ActorCritic, Agent, Settings
from algorithms.early_end import EarlyEnd
from algorithms.experience.evaluation import episode_returns
from algorithms.experience.rollout import Rollout, start_states
from algorithms.failing_rows import call_each, early_end, found
from algorithms.matching.losses import Matching, is_matched
from algorithms.measurement import HISTORY, MEASURE_EVERY, Measurement
from algorithms.networks.policy import Policies
from algorithms.networks.scaling import Coordinates, coordinates_of
from algorithms.snapshot import Snapshot
from algorithms.state import Saved, State, part, within
from algorithms.stopwatch import Cost, Stopwatch
from algorithms.threads import one_thread
from physics.environment import Environment

Config = TypeVar("Config", bound=Settings)
NewActorCritic = Callable[[Environment, Coordinates, int, Matching, Config], ActorCritic]
"""`(environment, coordinates, seed, matching, config)` -> an untrained actor-critic."""


class OffPolicyLearner:
    """A cohort of agents on one task; see `algorithms.learner.Learner`."""

    def __init__(
        self,
        environment: Environment,
        agents: Sequence[Agent],
        rollout: Rollout,
        *,
        stopwatch: Stopwatch,
        timesteps: int,
        rollout_steps: int,
    ) -> None:
        """Combine agents with the rollout of their steps, with seeds in the same order."""
        self._environment = environment
        self._agents = list(agents)
        self._rollout = rollout
        self._shape = agents[0].actor_shape
        self._exploring = Policies([agent.exploring_policy() for agent in agents], self._shape)
        self._timesteps = timesteps
        self._rollout_steps = rollout_steps
        self._histories = {agent.seed: deque[float](maxlen=HISTORY) for agent in agents}
        self._stopwatch = stopwatch
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

    def advance(self) -> list[Measurement | EarlyEnd]:
        """Run one cycle."""
        with one_thread():
            ends = self._act()
            ends += self._train(lambda agent: agent.learn())
            is_due = self.timestep % MEASURE_EVERY == 0 or self.timestep == self._timesteps
            with self._stopwatch.aside():
                measured = self._measure(ends) if is_due else []
        return [*ends, *(self._measurement(*each) for each in measured)]

    def drop(self, seeds: Collection[int]) -> None:
        """Stop training these seeds."""
        rows = [row for row, agent in enumerate(self._agents) if agent.seed not in seeds]
        self._agents = [self._agents[row] for row in rows]
        self._rollout.keep(rows)
        self._exploring.keep(rows)
        self._stopwatch.keep(self.seeds)

    def state(self, seed: int) -> State:
        """All values on which the run's next bits depend, except its journal."""
        k = self.seeds.index(seed)
        own = {
            "timestep": np.array(self.timestep),
            "history": np.array(self._histories[seed], np.float64),
            **self._stopwatch.costs[seed].state(),
        }
        agent, rollout = self._agents[k].state(), self._rollout.state(k)
        return own | within("agent", agent) | within("rollout", rollout)

    def journal(self, seed: int, start: int) -> State:
        """States, actions and ends of the timesteps from `start` on that its replay still holds."""
        return self._agents[self.seeds.index(seed)].replay.journal(start)

    def restore(self, saved: Mapping[int, Saved]) -> None:
        """Restore every run as it was saved; its replay is recomputed from its journal."""
        [self.timestep] = {int(saved[seed].state["timestep"]) for seed in self.seeds}
        for k, agent in enumerate(self._agents):
            state, journal = saved[agent.seed]
            self._stopwatch.costs[agent.seed].restore(state)
            self._histories[agent.seed].extend(state["history"].tolist())
            self._rollout.restore(k, part(state, "rollout"))
            agent.restore(part(state, "agent"))
            with one_thread(), self._stopwatch.aside():
                agent.replay.refill(self.timestep, journal, self._rollout.work_out)

    def snapshot(self, seed: int) -> Snapshot:
        """What the run has learned so far."""
        return self._agents[self.seeds.index(seed)].snapshot(self.timestep)

    def _act(self) -> list[EarlyEnd]:
        """Take a cycle's steps, stopping where a measurement is due."""
        due = MEASURE_EVERY - self.timestep % MEASURE_EVERY
        steps = min(self._rollout_steps, due, self._timesteps - self.timestep)
        with self._stopwatch.training(self.seeds):
            for k in range(len(self._agents)):
                self._explore_anew(k)
            experiences = self._rollout.collect(steps, self._exploring, self._explore_anew)
        self.timestep += steps
        lived = dict(zip(self.seeds, experiences, strict=True))
        return self._train(lambda agent: agent.remember(found(lived[agent.seed])))

    def _explore_anew(self, k: int) -> None:
        self._exploring.set(k, self._agents[k].exploring_policy())

    def _train(self, call: Callable[[Agent], None]) -> list[EarlyEnd]:
        """Call for every agent, timed as its training."""

        def timed(agent: Agent) -> None:
            with self._stopwatch.training([agent.seed]):
                call(agent)

        return self._each(timed)

    def _each(self, call: Callable[[Agent], None]) -> list[EarlyEnd]:
        """Call for every agent; drop those for which it raises."""
        ends = call_each(
            call,
            self._agents,
            lambda agent, error: early_end(agent.seed, self.timestep, agent.updates + 1, error),
        )
        if ends:
            self.drop({end.seed for end in ends})
        return ends

    def _measure(self, ends: list[EarlyEnd]) -> list[tuple[Agent, float, dict[str, float]]]:
        """Each agent with the return of an evaluation episode and its diagnostics.

        Agents for which this raises are dropped, and their ends are added to `ends`.
        """
        if not self._agents:
            return []
        policies = Policies([agent.policy() for agent in self._agents], self._shape)
        index = math.ceil(self.timestep / MEASURE_EVERY)
        starts, unborn = start_states(
            self._environment, [(seed, "evaluation", index) for seed in self.seeds]
        )
        returns, failures = episode_returns(self._environment, policies, starts)
        earned = dict(zip(self.seeds, [*returns], strict=True))
        earned |= {self.seeds[k]: error for k, error in (failures | unborn).items()}
        measured: list[tuple[Agent, float, dict[str, float]]] = []

        def measure(agent: Agent) -> None:
            value = float(found(earned[agent.seed]))
            measured.append((agent, value, agent.diagnose(self.timestep)))

        ends += self._each(measure)
        return measured

    def _measurement(
        self, agent: Agent, return_mean: float, diagnostics: dict[str, float]
    ) -> Measurement:
        history, cost = self._histories[agent.seed], self._stopwatch.costs[agent.seed]
        history.append(return_mean)
        return Measurement(
            seed=agent.seed,
            timestep=self.timestep,
            return_mean=return_mean,
            return_history=float(np.mean(history)),
            updates=agent.updates,
            jacobians=agent.jacobians,
            seconds=cost.seconds,
            compile_seconds=cost.compile_seconds,
            diagnostics=diagnostics,
        )


def cohort(
    new: NewActorCritic[Config],
    environment: Environment,
    seeds: Sequence[int],
    matching: Matching,
    timesteps: int,
    config: Config,
    *,
    time_limit_is_terminal: bool = False,
) -> OffPolicyLearner:
    """A cohort of runs, each with a new actor-critic."""
    coordinates, linearized = coordinates_of(environment), is_matched(matching)
    stopwatch = Stopwatch({seed: Cost() for seed in seeds})
    with stopwatch.aside():
        agents = [
            Agent(
                environment, coordinates, seed,
                new(environment, coordinates, seed, matching, config),
                timesteps, config, linearized=linearized,
            )
            for seed in seeds
        ]  # fmt: skip
        rollout = Rollout(
            environment, coordinates, seeds,
            linearized=linearized, time_limit_is_terminal=time_limit_is_terminal,
        )  # fmt: skip
    return OffPolicyLearner(
        environment, agents, rollout,
        stopwatch=stopwatch, timesteps=timesteps, rollout_steps=config.rollout_steps,
    )  # fmt: skip
