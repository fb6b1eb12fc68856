"""One run of gradient ascent (see `algorithms.ascent.learner`): its actor, and how far it is."""

import numpy as np

from algorithms.ascent.episode_gradient import LinearizedEpisodes, return_gradient
from algorithms.early_end import NotFiniteQuantityError
from algorithms.history import History
from algorithms.measurement import Measurement
from algorithms.memory import episode_bytes
from algorithms.networks import network
from algorithms.networks.finite import is_finite
from algorithms.networks.layer import Array
from algorithms.networks.optimizer import Learned, adam, corrected, learned
from algorithms.networks.policy import Policy, deterministic
from algorithms.networks.scaling import Coordinates, Statistics
from algorithms.settings import GDConfig
from algorithms.snapshot import Snapshot, inside
from algorithms.state import State, part, within
from physics.environment import Environment
from physics.kernels.compiled import compiled_fast
from physics.randomness import generator

SMOOTHED = 10
"""Measurements whose mean tells whether a curve still rises."""


class GDRun:
    """One actor and how far it has come.

    Attributes:
        history: its measurements.
        timestep: steps of its episodes so far, each with its Jacobian.
        updates: steps of Adam so far.
    """

    def __init__(
        self,
        environment: Environment,
        coordinates: Coordinates,
        seed: int,
        timesteps: int,
        config: GDConfig,
    ) -> None:
        """Draw the initial actor."""
        self.history = History(seed, timesteps)
        self.timestep = 0
        self.updates = 0
        self._config = config
        self._environment = environment
        self._shape = network.shape_of(environment.feature_size, environment.action_size, config)
        self._actor = learned(network.initial(self._shape, generator(seed, "actor")))
        self._statistics = Statistics(coordinates, environment.action_size)
        self._gradient_norms: list[float] = []
        self._best = -np.inf
        self._best_at = 0

    def count(self, episodes: LinearizedEpisodes) -> None:
        """Count the steps of the coming update's episodes."""
        self.timestep += int(episodes.ends.sum())

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

    def learn(self, episodes: LinearizedEpisodes) -> None:
        """Update the actor from its episodes."""
        theta, mean, inverse, _ = self.policy()
        gradient = np.empty_like(theta)
        return_gradient(
            theta, self._shape, mean, inverse, self._environment.feature_sources, episodes, gradient
        )
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

    def measured(self, return_mean: float) -> Measurement:
        """Take in a measurement."""
        norms, self._gradient_norms = self._gradient_norms, []
        self.history.record(return_mean)
        measurement = self.history.measured(
            updates=self.updates,
            jacobians=self.timestep,
            diagnostics={"gradient_norm": float(np.median(norms)) if norms else np.nan},
        )
        latest = float(np.mean([*self.history.returns][-SMOOTHED:]))
        if latest > self._best:
            self._best, self._best_at = latest, self.history.count
        return measurement

    @property
    def is_on_plateau(self) -> bool:
        """Whether its curve has not risen for long."""
        return self.history.count - self._best_at >= self._config.patience

    @property
    def nbytes(self) -> int:
        """Memory of one update's episodes."""
        return episode_bytes(self._environment, self._config)

    def state(self) -> State:
        """All that its next bits depend on."""
        own = {
            "timestep": np.array(self.timestep),
            "updates": np.array(self.updates),
            "best": np.array(self._best),
            "best_at": np.array(self._best_at),
            "gradient_norms": np.array(self._gradient_norms, np.float64),
        }
        return (
            own
            | within("actor", self._actor.state())
            | within("statistics", self._statistics.state())
            | within("history", self.history.state())
        )

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        self.timestep = int(state["timestep"])
        self.updates = int(state["updates"])
        self._best = float(state["best"])
        self._best_at = int(state["best_at"])
        self._gradient_norms = state["gradient_norms"].tolist()
        self._actor.restore(part(state, "actor"))
        self._statistics.restore(part(state, "statistics"))
        self.history.restore(part(state, "history"))

    def snapshot(self) -> Snapshot:
        """The actor as it is."""
        return Snapshot(self.timestep, self._shape.outputs, inside(self._shape), self.policy())


@compiled_fast
def climb(
    actor: Learned, gradient: Array, rate: float, update: int, clip: float
) -> tuple[float, bool]:
    """Step the actor up a gradient; return the gradient's norm and whether the actor is finite."""
    square = 0.0
    for i in range(gradient.size):
        square += np.float64(gradient[i]) * np.float64(gradient[i])
    norm = np.sqrt(square)
    if not is_finite(norm):
        return norm, True
    scale = -min(1.0, clip / norm) if norm > 0.0 else -1.0
    for i in range(gradient.size):
        gradient[i] *= scale
    _, theta_norm = adam(actor, gradient, corrected(rate, update))
    return norm, bool(is_finite(theta_norm))
