"""The learner of runs that learn from windows; see `algorithms.on_policy.learner`."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from algorithms.failing_rows import found
from algorithms.networks.scaling import coordinates_of
from algorithms.on_policy.actor import Explorers
from algorithms.on_policy.learner import OnPolicyLearner
from algorithms.on_policy.run import Rule, Settings, WindowRun
from algorithms.on_policy.window import Window, live, of_run
from physics.environment import Environment


class WindowLearner(OnPolicyLearner[WindowRun, Window]):
    """A cohort of runs, all with the same settings."""

    def __init__(
        self,
        environment: Environment,
        seeds: Sequence[int],
        timesteps: int,
        config: Settings,
        rule: Rule,
    ) -> None:
        """Draw the initial networks."""
        coordinates = coordinates_of(environment)
        runs = [
            WindowRun(environment, coordinates, seed, timesteps, config, rule) for seed in seeds
        ]
        super().__init__(environment, runs, runs[0].networks.actor_shape, timesteps)
        self._linearized = rule.linearized
        self._each_has = config.environments

    def _live(self) -> dict[int, Callable[[], Window]]:
        each = self._each_has
        noise = np.concatenate([run.noise_ahead() for run in self._runs], axis=1)
        explorers = Explorers([run.policy() for run in self._runs], noise, self._shape)
        windows, failures = live(
            self._environment, [run.episodes for run in self._runs], explorers.act, noise,
            linearized=self._linearized,
        )  # fmt: skip
        errors = {column // each: error for column, error in failures.items()}

        def window_of(k: int) -> Window:
            return found(errors[k] if windows is None or k in errors else of_run(windows, k, each))

        return {seed: partial(window_of, k) for k, seed in enumerate(self.seeds)}
