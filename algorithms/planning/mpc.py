"""MPC: model-predictive control by iLQR in a receding horizon, for a cohort of runs.

At time t of its one episode a run improves its plan for steps t to t + H - 1, applies the plan's
first action, and moves on:

    a_t .. a_{t+H-1}  <-  iLQR from  a_t .. a_{t+H-1}                  (algorithms.planning.planner)
    s_{t+1} = f(s_t, a_t)

The first plan covers the whole episode: it is one rollout of the initial actor of every learner of
that seed, from the start state of its first episode. So a plan that moves on adds the next of that
actor's actions, and no action has to be invented.

Plans are made without the task's noise, which is unknown, and from the state itself, not from its
observation. An action is applied with the noise, and the plan continues from the resulting state.

Measurements. A run simulates one episode, over and over, instead of many. Its curve is the
predicted return of the episode: the rewards so far, those of the plan, and those of the initial
actions that remain after it. The prediction is renewed after every action, and the curve at
timestep k is the last prediction before k. `timestep` counts simulated steps, above all those of
planning, for every candidate of every line search: another learner would have used as many steps of
its environment. As everywhere, Jacobians are counted separately; simulating the initial actions
again for the prediction is evaluation, and is not counted. `return_history` is the mean of the
latest 100 predictions. A run ends with its episode, often long before `timesteps`; its last
measurement is the actual return of the episode.

The time per action, with the presets, for 16 runs at once on one core (AMD EPYC), is 30 ms for
CartPoleSwingUp (horizon 100, at most 3 iterations), and 640 ms for HalfCheetah (horizon 30, at most
12, while other work shared the machine). One `advance` took at most 0.03 s and 0.16 s.

Source: Tassa, Mansard and Todorov (2014). Differences from their MPC: there are several iterations
per action, until a plan has converged; regularisation is kept from action to action, like the plan.
"""

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from algorithms.early_end import EarlyEnd, NotFiniteQuantityError
from algorithms.experience.rollout import start_states
from algorithms.failing_rows import Failures, early_end
from algorithms.history import History
from algorithms.measurement import Measurement
from algorithms.networks.parameters import initial_theta
from algorithms.networks.policy import Policies, deterministic
from algorithms.networks.shape import Shape
from algorithms.planning.episodes import Episodes, act, replay, roll_out, window_return
from algorithms.planning.planner import Planner
from algorithms.settings import MPCConfig
from algorithms.state import Saved, State, part, within
from algorithms.stopwatch import Stopwatch
from algorithms.threads import one_thread
from physics.environment import Environment
from physics.randomness import generator

Integers = NDArray[np.int64]


class MPCLearner:
    """A cohort of planned episodes on one task; see `algorithms.learner.Learner`.

    Attributes:
        timestep: simulated steps, the fewest of any run.
    """

    def __init__(
        self, environment: Environment, seeds: Sequence[int], timesteps: int, config: MPCConfig
    ) -> None:
        """Roll out the initial actors."""
        self._environment = environment
        self._model = environment.without_noise()
        self._timesteps = timesteps
        self._config = config
        self._histories = [History(seed, timesteps) for seed in seeds]
        self._stopwatch = Stopwatch({history.seed: history.cost for history in self._histories})
        with one_thread(), self._stopwatch.training(seeds):
            episodes, failures = first_plans(self._model, seeds, config.hidden_units)
        self._planner = Planner(self._model, episodes)
        self._planner.failures |= failures
        self._planner.simulated[:] = episodes.ends
        self._times = np.zeros(len(seeds), np.int64)
        self._iterations = np.zeros(len(seeds), np.int64)
        self.timestep = 0
        everyone = np.arange(len(seeds))
        self._predict(everyone)
        self._planner.begin(everyone)

    @property
    def seeds(self) -> list[int]:
        """The seeds still in training."""
        return [history.seed for history in self._histories]

    @property
    def finished(self) -> bool:
        """Whether nothing is left to do."""
        return not self._histories

    @property
    def bytes_per_run(self) -> int:
        """The size of a plan with its expansion."""
        return self._planner.bytes_per_plan

    def advance(self) -> list[Measurement | EarlyEnd]:
        """Do one iteration of every plan or, once all are finished, apply their next actions.

        Runs that were restored at a later step wait for the others.
        """
        ends = self._lose()
        measured = self._advance() if self._histories else []
        gone = self._lose()
        lost = {end.seed for end in gone}
        if self._histories:
            self._leave()
        return [*ends, *(m for m in measured if m.seed not in lost), *gone]

    def _advance(self) -> list[Measurement]:
        """Advance the remaining runs."""
        now = int(self._times.min())
        stop = min(now + self._config.horizon, self._environment.horizon)
        here = self._times == now
        unfinished = here & self._planner.is_active & (self._iterations < self._config.iterations)
        with one_thread():
            if unfinished.any():
                self._iterate(now, stop, np.flatnonzero(unfinished))
                return self._measure()
            return self._act(now, stop, np.flatnonzero(here))

    def drop(self, seeds: Collection[int]) -> None:
        """Stop these runs."""
        self._keep([row for row, seed in enumerate(self.seeds) if seed not in seeds])

    def state(self, seed: int) -> State:
        """All values on which the run's next bits depend."""
        p = self.seeds.index(seed)
        own = {"time": np.array(self._times[p]), "iterations": np.array(self._iterations[p])}
        history, plan = self._histories[p].state(), self._planner.state(p)
        return own | within("history", history) | within("plan", plan)

    def journal(self, seed: int, start: int) -> State:
        """Empty: the plan holds the whole episode."""
        del seed, start
        return {}

    def restore(self, saved: Mapping[int, Saved]) -> None:
        """Restore every run as it was saved."""
        for p, history in enumerate(self._histories):
            state = saved[history.seed].state
            self._times[p] = state["time"]
            self._iterations[p] = state["iterations"]
            history.restore(part(state, "history"))
            self._planner.restore(p, int(self._times[p]), part(state, "plan"))
        self._count()

    def snapshot(self, seed: int) -> None:
        """None: a plan is not a policy."""
        del seed

    def _iterate(self, now: int, stop: int, plans: Integers) -> None:
        """Improve these plans for steps `now` to `stop` - 1."""
        with self._stopwatch.training([self.seeds[p] for p in plans]):
            self._planner.iterate(now, stop, plans)
        self._iterations[plans] += 1

    def _act(self, now: int, stop: int, plans: Integers) -> list[Measurement]:
        """Apply the action of these plans at step `now`, which end before `stop`; move them on."""
        episodes = self._planner.episodes
        with self._stopwatch.aside():
            if self._model is self._environment:  # without noise, the plan holds the result
                self._planner.failures |= replay(self._model, episodes, stop)
            else:
                self._planner.failures |= act(self._environment, self._model, episodes, now, plans)
                self._planner.has_moved(plans, now + 1)
                self._planner.simulated[plans] += stop - (now + 1)
        self._planner.simulated[plans] += episodes.ends[plans] > stop  # the step that the plan adds
        measured = self._measure()
        self._times[plans] += 1
        self._iterations[plans] = 0
        self._predict(plans)
        self._planner.begin(plans)
        return measured + self._measure_ends()

    def _predict(self, plans: Integers) -> None:
        """Record the current predicted returns of these episodes."""
        for p in plans:
            with self._stopwatch.aside():
                value = window_return(self._planner.episodes, p, 0, self._environment.horizon)
            if not math.isfinite(value):
                self._planner.failures.setdefault(int(p), NotFiniteQuantityError("return"))
            self._histories[p].record(value)

    def _measure(self) -> list[Measurement]:
        """The measurements that have become due."""
        simulated = np.minimum(self._planner.simulated, self._timesteps)
        return [
            self._measured(p)
            for p, history in enumerate(self._histories)
            for _ in history.due(int(simulated[p]))
        ]

    def _measure_ends(self) -> list[Measurement]:
        """A last measurement of the episodes that are over."""
        is_over = self._planner.episodes.ends <= self._times
        return [
            self._measured(p)
            for p, history in enumerate(self._histories)
            if is_over[p] and not history.is_complete
        ]

    def _measured(self, p: int) -> Measurement:
        planner = self._planner
        return self._histories[p].measured(
            updates=int(planner.iterations[p]),
            jacobians=int(planner.jacobians[p]),
            diagnostics={
                "actions": float(self._times[p]),
                "collected_return": window_return(planner.episodes, p, 0, int(self._times[p])),
                "regularisation": float(planner.regularisation.level[p]),
            },
        )

    def _lose(self) -> list[EarlyEnd]:
        """Drop the runs whose plans failed; return their early ends."""
        planner = self._planner
        ends = [
            early_end(
                self.seeds[p], int(min(planner.simulated[p], self._timesteps)),
                int(planner.iterations[p]) + 1, error,
            )
            for p, error in sorted(planner.failures.items())
        ]  # fmt: skip
        if ends:
            self.drop({end.seed for end in ends})
        return ends

    def _leave(self) -> None:
        """Drop the runs whose episode is over, or which have used their timesteps."""
        self._count()
        planner = self._planner
        stays = (planner.episodes.ends > self._times) & (planner.simulated < self._timesteps)
        if not stays.all():
            self._keep(np.flatnonzero(stays).tolist())

    def _count(self) -> None:
        self.timestep = int(min(self._planner.simulated.min(), self._timesteps))

    def _keep(self, rows: list[int]) -> None:
        self._planner.keep(rows)
        self._histories = [self._histories[row] for row in rows]
        self._times, self._iterations = self._times[rows], self._iterations[rows]
        self._stopwatch.keep(self.seeds)


def first_plans(
    environment: Environment, seeds: Sequence[int], hidden_units: int
) -> tuple[Episodes, Failures]:
    """An episode of each seed's initial actor, with unnormalised features; and the failures."""
    shape = Shape(environment.feature_size, (hidden_units,) * 2, environment.action_size)
    mean = np.zeros(shape.inputs, np.float32)
    actors = [
        deterministic(
            initial_theta(shape, generator(seed, "actor")),
            mean,
            np.ones_like(mean),
            environment.action_size,
        )
        for seed in seeds
    ]
    policies = Policies(actors, shape)
    starts, unborn = start_states(environment, [(seed, "episode", 0) for seed in seeds])
    episodes, failures = roll_out(
        environment, starts, lambda states: policies.act(environment.features(states))
    )
    return episodes, failures | unborn


def build(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: MPCConfig,
) -> MPCLearner:
    """A cohort of MPC runs, which do not use the weights."""
    del weights
    return MPCLearner(environment, seeds, timesteps, config)
