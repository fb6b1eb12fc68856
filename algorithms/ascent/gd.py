"""GD: gradient ascent on the return itself, through the simulator, for a cohort of runs.

    theta  up   1/E sum over episodes of dR/dtheta          (algorithms.ascent.episodes)

Each update runs E whole episodes under the deterministic actor, from new start states, and takes
one step of Adam along the exact gradient of their mean undiscounted return; its norm is clipped,
since it may be arbitrarily large over a hundred steps of a chaotic system. A gradient or an actor
that is not finite ends the run.

The initial actor is that of the other learners of that seed. Its features are normalised as theirs,
by the mean and standard deviation over the whole run so far; these change between updates.

A run ends at its timesteps, or when its curve has reached a plateau: when the mean of its latest
ten `return_mean` has had no new best for `patience` measurements.

Sources: Hu et al. (2019) and Degrave et al. (2019), as summarised in the paper's section 5.2; Adam,
Kingma and Ba (2014). The backward pass through an episode is written out and compiled, instead of
autograd through `physics.torch_step`: the derivatives are the same, and tests compare the two. The
paper does not specify the step size, the number of episodes and the clipping.
"""

from collections.abc import Callable, Sequence
from functools import partial

from algorithms.ascent.episodes import live
from algorithms.ascent.gd_run import GDRun
from algorithms.ascent.pathwise import Linearized
from algorithms.experience.rollout import start_states
from algorithms.failing_rows import found
from algorithms.networks.scaling import coordinates_of
from algorithms.networks.shape import shape_of
from algorithms.on_policy.learner import OnPolicyLearner
from algorithms.settings import GDConfig
from physics.environment import Environment


class GDLearner(OnPolicyLearner[GDRun, Linearized]):
    """A cohort of runs that learn from whole episodes; short episodes cost fewer timesteps."""

    def __init__(
        self, environment: Environment, seeds: Sequence[int], timesteps: int, config: GDConfig
    ) -> None:
        """Draw the initial actors."""
        coordinates = coordinates_of(environment)
        runs = [GDRun(environment, coordinates, seed, timesteps, config) for seed in seeds]
        shape = shape_of(environment.feature_size, environment.action_size, config)
        super().__init__(environment, runs, shape, timesteps)

    def _live(self) -> dict[int, Callable[[], Linearized]]:
        purposes = [run.episodes_ahead() for run in self._runs]
        starts, unborn = start_states(self._environment, [each for run in purposes for each in run])
        shape = (len(purposes), -1, self._environment.state_size)
        episodes, failures = live(
            self._environment, [r.policy() for r in self._runs], self._shape, starts.reshape(shape)
        )
        each = len(starts) // len(purposes)
        errors = {row // each: error for row, error in (failures | unborn).items()}

        def episodes_of(k: int) -> Linearized:
            return found(errors[k] if episodes is None or k in errors else episodes.of(k))

        return {seed: partial(episodes_of, k) for k, seed in enumerate(self.seeds)}


def build(
    environment: Environment,
    seeds: Sequence[int],
    weights: tuple[float, float],
    timesteps: int,
    config: GDConfig,
) -> GDLearner:
    """A cohort of GD runs, which do not use the weights."""
    del weights
    return GDLearner(environment, seeds, timesteps, config)
