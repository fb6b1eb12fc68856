"""One run of gradient ascent (see `algorithms.ascent.gd`): its actor and its progress."""

import numpy as np

from algorithms.ascent.episodes import return_gradient
from algorithms.ascent.pathwise import Linearized
from algorithms.early_end import NotFiniteQuantityError
from algorithms.measurement import Measurement
from algorithms.memory import episode_bytes
from algorithms.networks.finite import is_finite
from algorithms.networks.layer import Array
from algorithms.networks.optimizer import USUAL, Learned, clipped_step, corrected, learned
from algorithms.networks.parameters import initial_theta
from algorithms.networks.policy import Policy, deterministic
from algorithms.networks.scaling import Coordinates, Statistics
from algorithms.networks.shape import shape_of
from algorithms.on_policy.counted_run import CountedRun, Part
from algorithms.settings import GDConfig
from algorithms.snapshot import Snapshot, inside
from algorithms.state import State
from physics.environment import Environment
from physics.kernels.compiled import compiled_fast
from physics.randomness import generator

SMOOTHED = 10
"""The number of measurements whose mean shows whether a curve still rises."""


class GDRun(CountedRun):
    """One actor and its progress in steps of its episodes, each with its Jacobian."""

    counters = (*CountedRun.counters, "_best_at")
    learned = ("_best",)

    def __init__(
        self,
        environment: Environment,
        coordinates: Coordinates,
        seed: int,
        timesteps: int,
        config: GDConfig,
    ) -> None:
        """Draw the initial actor."""
        super().__init__(seed, timesteps)
        self._config = config
        self._environment = environment
        self._shape = shape_of(environment.feature_size, environment.action_size, config)
        self._actor = learned(initial_theta(self._shape, generator(seed, "actor")))
        self._statistics = Statistics(coordinates, environment.action_size)
        self._gradient_norms: list[float] = []
        self._best = -np.inf
        self._best_at = 0

    def count(self, episodes: Linearized) -> None:
        """Count the steps of the coming update's episodes."""
        self.timestep += int(episodes.ends.sum())
        self.jacobians = self.timestep

    def policy(self) -> Policy:
        """The actor as it is."""
        scaling = self._statistics.scaling()
        m = self._shape.outputs
        return deterministic(self._actor.theta, scaling.mean, scaling.inverse, m)

    def episodes_ahead(self) -> list[tuple[int, str, int]]:
        """Where the next update's episodes start, for `start_states`."""
        each = self._config.episodes
        first = self.updates * each
        return [(self.history.seed, "episode", i) for i in range(first, first + each)]

    def learn(self, episodes: Linearized) -> None:
        """Update the actor from its episodes."""
        policy, gradient = self.policy(), np.empty_like(self._actor.theta)
        return_gradient(policy, self._shape, self._environment.feature_sources, episodes, gradient)
        norm, still_finite = climb(
            self._actor, gradient, self._config.rate, self.updates + 1, self._config.clip
        )
        if not np.isfinite(norm):
            raise NotFiniteQuantityError("actor gradient")
        if not still_finite:
            raise NotFiniteQuantityError("actor parameters")
        self.updates += 1
        self._gradient_norms.append(norm)
        for e, end in enumerate(episodes.ends):
            self._statistics.observe(episodes.features[:end, e].astype(np.float32))

    def diagnostics(self) -> dict[str, float]:
        """The median norm of the gradients since the last measurement."""
        norms, self._gradient_norms = self._gradient_norms, []
        return {"gradient_norm": float(np.median(norms)) if norms else np.nan}

    def measured(self, return_mean: float) -> Measurement:
        """Return the next measurement, and note whether it is a new best."""
        measurement = super().measured(return_mean)
        latest = float(np.mean([*self.history.returns][-SMOOTHED:]))
        if latest > self._best:
            self._best, self._best_at = latest, self.history.count
        return measurement

    @property
    def is_over(self) -> bool:
        """Whether it has used its timesteps, or its curve is on a plateau."""
        on_plateau = self.history.count - self._best_at >= self._config.patience
        return on_plateau or super().is_over

    @property
    def nbytes(self) -> int:
        """Memory of one update's episodes."""
        return episode_bytes(self._environment, self._config)

    def parts(self) -> dict[str, Part]:
        """The actor, and the statistics of its features."""
        return {"actor": self._actor, "statistics": self._statistics}

    def state(self) -> State:
        """All values on which its next bits depend."""
        norms = np.array(self._gradient_norms, np.float64)
        return {**super().state(), "gradient_norms": norms}

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        super().restore(state)
        self._gradient_norms = state["gradient_norms"].tolist()

    def snapshot(self) -> Snapshot:
        """The actor as it is."""
        return Snapshot(self.timestep, self._shape.outputs, inside(self._shape), self.policy())


@compiled_fast
def climb(
    actor: Learned, gradient: Array, rate: float, update: int, clip: float
) -> tuple[float, bool]:
    """Step the actor up a gradient; return the gradient's norm and whether the actor is finite."""
    for i in range(gradient.size):
        gradient[i] = -gradient[i]
    norm, size = clipped_step(actor, gradient, clip, corrected(rate, update), USUAL)
    return norm, bool(is_finite(size))
