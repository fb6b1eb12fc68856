"""The same update in JAX, as a peer: jitted, with a cycle scanned and the seeds vmapped.

Networks, losses, targets, weight decay, Adam and Polyak averaging are those of
`algorithms.actor_critic.ddpg` and its L2 hybrid, on random transitions of the same sizes (features
are coordinates, so that the critic's input gradient is the matched gradient). Normalisation, noise
and diagnostics are left out, in the peer's favour. The matched gradient is computed by `jax.grad`
and differentiated again by JAX.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

GAMMA, TAU, ACTOR_RATE, CRITIC_RATE, DECAY = 0.99, 0.01, 1e-4, 1e-3, 1e-2
Tree = Any


class Transitions(NamedTuple):
    """A replay of N transitions, or a batch of it."""

    state: jax.Array
    action: jax.Array
    reward: jax.Array
    next_state: jax.Array
    reward_gradient: jax.Array
    """[N, n + m]"""
    jacobian: jax.Array
    """[N, n, n + m]"""


class Network(NamedTuple):
    """Parameters, their slowly following copy, and Adam's moments."""

    theta: Tree
    target: Tree
    m: Tree
    v: Tree


def cycle(
    seeds: int, updates: int, state: int, action: int, stored: int, weights: tuple[float, float]
) -> Callable[[], None]:
    """A function that does `updates` updates of each of `seeds` runs."""
    keys = jax.random.split(jax.random.key(0), seeds)
    build = jax.vmap(partial(initial, state=state, action=action, stored=stored))
    actor, critic, replay = jax.jit(build)(keys)
    scanned = jax.jit(jax.vmap(partial(run, updates=updates, weights=weights)))

    def learn() -> None:
        nonlocal actor, critic, keys
        actor, critic, keys = scanned(actor, critic, replay, keys)
        jax.block_until_ready(critic)

    return learn


def initial(key: Any, state: int, action: int, stored: int) -> tuple[Network, Network, Transitions]:
    """Networks of one run, and a replay full of random transitions."""
    names = iter(jax.random.split(key, 8))

    def normal(*shape: int) -> jax.Array:
        return jax.random.normal(next(names), shape)

    replay = Transitions(
        normal(stored, state),
        jnp.tanh(normal(stored, action)),
        normal(stored),
        normal(stored, state),
        normal(stored, state + action),
        normal(stored, state, state + action),
    )
    actor = learned(layers(next(names), state, action))
    return actor, learned(layers(next(names), state + action, 1)), replay


def layers(key: Any, inputs: int, outputs: int, hidden: int = 64) -> Tree:
    """Two hidden layers with layer normalisation, and a linear output."""
    keys = jax.random.split(key, 3)
    sizes = [(inputs, hidden), (hidden, hidden), (hidden, outputs)]
    return [
        {
            "weight": jax.random.uniform(k, size, minval=-1, maxval=1) * jnp.sqrt(6 / sum(size)),
            "bias": jnp.zeros(size[1]),
            "gain": jnp.ones(size[1]),
            "shift": jnp.zeros(size[1]),
        }
        for k, size in zip(keys, sizes, strict=True)
    ]


def learned(theta: Tree) -> Network:
    zeros = jax.tree.map(jnp.zeros_like, theta)
    return Network(theta, theta, zeros, zeros)


def forward(theta: Tree, x: jax.Array) -> jax.Array:
    for layer in theta[:-1]:
        z = x @ layer["weight"] + layer["bias"]
        z = z - z.mean(-1, keepdims=True)
        n = z * jax.lax.rsqrt((z * z).mean(-1, keepdims=True) + 1e-5)
        x = jnp.tanh(layer["gain"] * n + layer["shift"])
    return x @ theta[-1]["weight"] + theta[-1]["bias"]


def act(theta: Tree, state: jax.Array) -> jax.Array:
    return jnp.tanh(forward(theta, state))


def values(theta: Tree, z: jax.Array) -> jax.Array:
    return forward(theta, z)[..., 0]


def run(
    actor: Network, critic: Network, replay: Transitions, key: Any, updates: int,
    weights: tuple[float, float],
) -> tuple[Network, Network, Any]:  # fmt: skip
    """A cycle of one run."""
    key, drawn = jax.random.split(key)
    indices = jax.random.randint(drawn, (updates, 64), 0, len(replay.reward))

    def one(networks: tuple[Network, Network], step: Any) -> tuple[tuple[Network, Network], None]:
        count, rows = step
        batch = jax.tree.map(lambda part: part[rows], replay)
        return update(*networks, batch, count, weights), None

    steps = (jnp.arange(1, updates + 1), indices)
    (actor, critic), _ = jax.lax.scan(one, (actor, critic), steps)
    return actor, critic, key


def update(
    actor: Network, critic: Network, batch: Transitions, count: jax.Array,
    weights: tuple[float, float],
) -> tuple[Network, Network]:  # fmt: skip
    """One step of both networks and of their targets."""
    n = batch.state.shape[1]
    z = jnp.concatenate([batch.state, batch.action], axis=1)

    def next_value(state: jax.Array) -> jax.Array:
        action = act(actor.target, state)
        return values(critic.target, jnp.concatenate([state, action], axis=1))

    def loss(theta: Tree) -> jax.Array:
        decayed = sum((layer["weight"] ** 2).sum() for layer in theta[:-1])
        total = ((values(theta, z) - target) ** 2).mean() + DECAY / 2 * decayed
        if any(weights):
            own = jax.grad(lambda inputs: values(theta, inputs).sum())(z)
            squares = ((own - target_gradient) ** 2).mean(0)
            total += weights[0] * squares[n:].sum() + weights[1] * squares[:n].sum()
        return total

    def actor_loss(theta: Tree) -> jax.Array:
        inputs = jnp.concatenate([batch.state, act(theta, batch.state)], axis=1)
        return -values(critic.theta, inputs).mean()

    target = batch.reward + GAMMA * next_value(batch.next_state)
    if any(weights):
        slope = jax.grad(lambda state: next_value(state).sum())(batch.next_state)
        target_gradient = batch.reward_gradient + GAMMA * jnp.einsum(
            "bi,bij->bj", slope, batch.jacobian
        )
    critic_gradient, actor_gradient = (
        jax.grad(loss)(critic.theta),
        jax.grad(actor_loss)(actor.theta),
    )
    return (
        adam(actor, actor_gradient, ACTOR_RATE, count),
        adam(critic, critic_gradient, CRITIC_RATE, count),
    )


def adam(network: Network, gradient: Tree, rate: float, count: jax.Array) -> Network:
    m = jax.tree.map(lambda m, g: m + 0.1 * (g - m), network.m, gradient)
    v = jax.tree.map(lambda v, g: v + 0.001 * (g * g - v), network.v, gradient)
    step = rate * jnp.sqrt(1 - 0.999**count) / (1 - 0.9**count)
    theta = jax.tree.map(lambda t, m, v: t - step * m / (jnp.sqrt(v) + 1e-8), network.theta, m, v)
    target = jax.tree.map(lambda old, new: old + TAU * (new - old), network.target, theta)
    return Network(theta, target, m, v)
