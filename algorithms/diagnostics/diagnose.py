"""Diagnose: measures where the simulator's gradients can help a run, and where they cannot.

    smoothing   bias and variance of the exact gradient           (.smoothing)
    growth      norms of products of closed-loop Jacobians        (.growth)
    kinks       steps that cross from one smooth piece to another (.kinks)
    critic      the critic's gradient beside the rollout's
    target      the same beside its own bootstrapped target       (both: .critic_gradient)
    loss        the share of a batch's gradient loss in a hundredth of its rows

All are measured along episodes of the run's deterministic policy. Gradients in states are in units
of each coordinate's spread in training, and without the coordinates that no network sees.
"""

import numpy as np

import physics
from algorithms.diagnostics.closed_loop import Gradient, Rollouts, roll_out, value_gradient
from algorithms.diagnostics.critic_gradient import (
    agreement,
    bootstrapped_gradient,
    square_distance,
    top_share,
)
from algorithms.diagnostics.finding import Finding
from algorithms.diagnostics.growth import closed_loop_jacobians, product_norms
from algorithms.diagnostics.kinks import kink_share, regime_shares
from algorithms.diagnostics.learned import LearnedCritic, LearnedPolicy, units
from algorithms.diagnostics.smoothing import smoothing
from algorithms.experience.rollout import start_states
from algorithms.failing_rows import found
from algorithms.snapshot import Snapshot
from algorithms.threads import one_thread
from physics.environment import Environment, FloatArray
from physics.randomness import generator

HORIZONS = (1, 2, 4, 8, 16, 32)
NOISES = (0.05, 0.2)
CUTS = (1, 4, 16, 64, 256)
"""Horizons of the rollouts with which a critic's gradient is compared."""
EPISODES, STATES, PAIRS, BATCH = 8, 16, 64, 1024
BATCH_NOISE = 0.2
"""The noise of a batch's actions, as in a replay: the aim of ddpg's parameter noise."""


def diagnose(
    environment: str | Environment | type[Environment],
    snapshot: Snapshot,
    gamma: float | None = None,
    seed: int = 0,
) -> list[Finding]:
    """Diagnose one run.

    Args:
        environment: a task: a name that `physics.make` takes, a class or an instance.
        snapshot: the result of the run, from `Learner.snapshot`.
        gamma: the run's discount. If it is None or the run has no critic, there are no findings
            about a critic.
        seed: the seed of the episodes and the noise. The same seed gives the same findings.

    Raises:
        ValueError: for an unknown task.
        NotFiniteError, UnsolvedStepError: if a step has no derivatives, or no solution.
    """
    task = physics.as_task(environment)
    with one_thread():
        policy, unit = LearnedPolicy(task, snapshot), units(task, snapshot)
        episodes = roll_out(task, policy, starts(task, seed), task.horizon)
        findings = [
            *of_smoothing(task, policy, visited(episodes, STATES, seed), seed),
            *of_growth(episodes, unit),
            *of_kinks(task, episodes),
        ]
        if gamma is not None and snapshot.critic is not None:
            critic = LearnedCritic(task, snapshot, snapshot.critic)
            states = visited(episodes, BATCH, seed)
            findings += of_critic(task, policy, critic, states[: 4 * STATES], gamma, unit)
            findings += of_loss(task, policy, critic, states, gamma, unit, seed)
    return findings


def starts(environment: Environment, seed: int) -> FloatArray:
    """The start states of the episodes. Raises the error of drawing one."""
    purposes = [(seed, "diagnostics: episode", i) for i in range(EPISODES)]
    states, failures = start_states(environment, purposes)
    for error in failures.values():
        found(error)
    return states


def visited(episodes: Rollouts, count: int, seed: int) -> FloatArray:
    """States [count, n] drawn from all steps of the episodes."""
    states = episodes.states[episodes.is_live]
    rows = generator(seed, "diagnostics: states").integers(len(states), size=count)
    drawn: FloatArray = states[rows]
    return drawn


def of_smoothing(
    environment: Environment, policy: LearnedPolicy, states: FloatArray, seed: int
) -> list[Finding]:
    """Both estimates of the gradient of the smoothed return, by horizon and noise."""
    return [
        Finding("smoothing", quantity, each.horizon, noise, getattr(each, quantity))
        for noise in NOISES
        for each in smoothing(environment, policy, states, HORIZONS, noise, pairs=PAIRS, seed=seed)
        for quantity in ("norm", "bias", "resolution", "exact_std", "zeroth_std")
    ]


def of_growth(episodes: Rollouts, unit: FloatArray) -> list[Finding]:
    """The median and the highest tenth of the norms of products, by horizon."""
    norms = product_norms(
        closed_loop_jacobians(episodes, unit), episodes.lengths.tolist(), HORIZONS
    )
    return [
        Finding("growth", quantity, horizon, None, float(np.quantile(each, level)))
        for horizon, each in norms.items()
        if each.size
        for quantity, level in (("median_norm", 0.5), ("high_norm", 0.9))
    ]


def of_kinks(environment: Environment, episodes: Rollouts) -> list[Finding]:
    """The share of steps that cross a kink, and of those in each regime."""
    shares = {"crossing": kink_share(environment, episodes)} | {
        f"in {name}": share for name, share in regime_shares(environment, episodes).items()
    }
    return [Finding("kinks", name, None, None, share) for name, share in shares.items()]


def of_critic(
    environment: Environment,
    policy: LearnedPolicy,
    critic: LearnedCritic,
    states: FloatArray,
    gamma: float,
    unit: FloatArray,
) -> list[Finding]:
    """Cosines of the critic's gradient, at the policy's actions, to its target and to rollouts."""
    rollouts = roll_out(environment, policy, states, max(CUTS))
    actions = rollouts.actions[0]
    own = critic(states, actions)
    target = bootstrapped_gradient(environment, policy, critic, states, actions, gamma)
    aims = {None: target} | {cut: value_gradient(rollouts, cut, gamma) for cut in CUTS}
    return [
        Finding("critic" if cut else "target", name, cut, None, value)
        for cut, aim in aims.items()
        for name, value in agreements(own, aim, unit).items()
    ]


def agreements(own: Gradient, aim: Gradient, unit: FloatArray) -> dict[str, float]:
    """How far each part of two gradients agrees."""
    action = agreement(own.by_action, aim.by_action)
    state = agreement(own.by_state * unit, aim.by_state * unit)
    return {
        "action_cosine": action.cosine,
        "action_rows": action.directed,
        "state_cosine": state.cosine,
        "state_rows": state.directed,
    }


def of_loss(
    environment: Environment,
    policy: LearnedPolicy,
    critic: LearnedCritic,
    states: FloatArray,
    gamma: float,
    unit: FloatArray,
    seed: int,
) -> list[Finding]:
    """The share of the top hundredth of the rows in each part of the L2 gradient loss."""
    chosen, _ = policy(states)
    draws = generator(seed, "diagnostics: batch")
    actions = np.clip(chosen + BATCH_NOISE * draws.standard_normal(chosen.shape), -1.0, 1.0)
    own = critic(states, actions)
    aim = bootstrapped_gradient(environment, policy, critic, states, actions, gamma)
    losses = {
        "action": square_distance(own.by_action, aim.by_action),
        "state": square_distance(own.by_state * unit, aim.by_state * unit),
    }
    return [
        Finding("loss", f"{part}_top_share", None, BATCH_NOISE, top_share(each))
        for part, each in losses.items()
    ]
