"""Simulators: steps and Jacobians per second of one pendulum in four forms, and of MuJoCo models.

The pendulum is the project's own task (compiled), and one of the same mass, length and torque as
torch functions, JAX functions and a MuJoCo model. For MuJoCo's ready-made tasks, `step` is compared
with `mujoco.rollout` of as many steps of the model from the same states, on one thread: the
difference is the task's work beyond MuJoCo's steps. All take turns, and the best round of each
counts. Finally the learners train on the forms, eight seeds at once; the rate is the timesteps of a
seed over the seconds in its measurements.
"""

import argparse
import os
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import torch
from mujoco.rollout import Rollout

import algorithms
import physics
from benchmarks.physics import BATCHES, Contender, best_rates, our_step, report
from physics.catalogue import EXTRAS
from physics.drawing import Drawing
from physics.environment import Environment, FloatArray
from physics.jax_engine import jnp
from physics.jax_environment import JaxEnvironment
from physics.mujoco import MujocoTask, TorchMujocoTask
from physics.torch_environment import TorchEnvironment

DT = 0.05
TRAINED = 4000
MODEL = """
<mujoco>
  <option timestep="0.05" gravity="0 0 -10"><flag contact="disable"/></option>
  <worldbody><body>
    <joint name="hinge" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 0 0 1" size="0.05" mass="1"/>
  </body></worldbody>
  <actuator><motor joint="hinge" ctrlrange="-2 2" ctrllimited="true"/></actuator>
</mujoco>
"""


def _reward(state: Any, action: Any, next_state: Any) -> Any:
    """The pendulum's reward, except for the wrapped angle."""
    del next_state
    return -(state[0] ** 2 + 0.1 * state[1] ** 2 + 0.001 * (2.0 * action[0]) ** 2)


def _dynamics(library: Any, state: Any, action: Any) -> Any:
    """Semi-implicit Euler in an array library."""
    angle, speed = state
    speed = speed + DT * (15.0 * library.sin(angle) + 3.0 * 2.0 * action[0])
    return library.stack([angle + DT * speed, speed])


class _Pendulum:
    """The shared part of the forms."""

    version = 1
    state_size = 2
    action_size = 1
    horizon = 200
    max_reward = 0.0

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return generator.uniform(-1.0, 1.0, 2)

    def draw(self, state: FloatArray) -> Drawing:
        del state
        return Drawing((-1.0, -1.0, 1.0, 1.0), ())


class InTorch(_Pendulum, TorchEnvironment):
    """The pendulum as torch functions."""

    name = "torch"

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        """See `_dynamics`."""
        moved: torch.Tensor = _dynamics(torch, state, action)
        return moved

    reward = staticmethod(_reward)


class InJax(_Pendulum, JaxEnvironment):
    """The pendulum as JAX functions."""

    name = "JAX"

    def dynamics(self, state: Any, action: Any) -> Any:
        """See `_dynamics`."""
        return _dynamics(jnp, state, action)

    reward = staticmethod(_reward)


class InMujoco(TorchMujocoTask):
    """The pendulum as a model, with the reward in torch."""

    name = "MuJoCo"
    version = 1
    horizon = 200
    max_reward = 0.0
    mjcf = MODEL
    reward = staticmethod(_reward)


def both(environment: Environment, batch: int) -> list[Contender]:
    """`step` and `differentiate`."""
    return [
        Contender("step", our_step(environment, batch, False), batch),
        Contender("with Jacobian", our_step(environment, batch, True), batch),
    ]


def trained(algorithm: str, environment: Environment) -> float:
    """Timesteps per second of one seed among eight."""
    last = {
        each.seed: each
        for each in algorithms.train(algorithm, environment, range(8), timesteps=TRAINED)
    }
    return len(last) * TRAINED / sum(each.seconds for each in last.values())


def rollout(task: MujocoTask, batch: int) -> Callable[[], None]:
    """MuJoCo's own batched steps, called like ours in `our_step`: each from the last state."""
    model, data = task.model, mujoco.MjData(task.model)
    # Never closed: it has no threads.
    pool = Rollout(nthread=0)
    starts = task.initial_states(range(batch))[:, : task.simulation.coordinates]
    starts = np.concatenate([np.zeros((batch, 1)), starts], axis=1)
    random, state, elapsed = np.random.default_rng(0), starts, 0
    actions = random.uniform(-1.0, 1.0, (64, batch, 1, task.action_size))
    controls = np.repeat(actions, task.substeps, axis=2)

    def step() -> None:
        nonlocal state, elapsed
        elapsed += 1
        if elapsed % task.horizon == 0:
            state = starts.copy()
        led, _ = pool.rollout(model, data, state, controls[elapsed % 64])
        state = led[:, -1]
        ended = task.ends(_padded(task, state[:, 1:]))
        if ended.any():
            state = np.where(ended[:, None], starts, state)

    return step


def _padded(task: MujocoTask, coordinates: FloatArray) -> FloatArray:
    """States with measures under which no episode ends."""
    rest = np.full((len(coordinates), task.state_size - task.simulation.coordinates), 2.0)
    return np.concatenate([coordinates, rest], axis=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", default=list(EXTRAS["mujoco"]), help="MuJoCo's tasks")
    parser.add_argument("--seconds", type=float, default=0.02, help="length of a round")
    parser.add_argument("--rounds", type=int, default=50)
    arguments = parser.parse_args()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    torch.set_num_threads(1)
    forms = [
        ("compiled", physics.make("Pendulum")),
        *((t.name, t()) for t in (InTorch, InJax, InMujoco)),
    ]
    for batch in BATCHES:
        contenders = [each for _, form in forms for each in both(form, batch)]
        rates = best_rates(contenders, arguments.seconds, arguments.rounds)
        labels = [f"{label}, {each.name}" for label, form in forms for each in both(form, batch)]
        for label, rate in zip(labels, rates, strict=True):
            report(f"Pendulum, batch {batch}, {label}", rate, "transitions/s")
    for algorithm in ("ddpg", "hybrid-ddpg-robust"):
        native, *others = [trained(algorithm, form) for _, form in forms]
        report(f"Pendulum, {algorithm}, compiled", native, "timesteps/s")
        for (label, _), rate in zip(forms[1:], others, strict=True):
            report(f"Pendulum, {algorithm}, {label}", rate, "timesteps/s")
            report(f"Pendulum, {algorithm}, {label} over compiled", rate / native, "x")
    for name in arguments.names:
        task = physics.make(name)
        assert isinstance(task, MujocoTask)
        for batch in BATCHES:
            peer = Contender("mujoco.rollout", rollout(task, batch), batch)
            stepping, differentiating, theirs = best_rates(
                [*both(task, batch), peer], arguments.seconds, arguments.rounds
            )
            report(f"{name}, batch {batch}, step", stepping, "transitions/s")
            report(f"{name}, batch {batch}, with Jacobian", differentiating, "transitions/s")
            report(f"{name}, batch {batch}, mujoco.rollout", theirs, "transitions/s")
            report(f"{name}, batch {batch}, step over mujoco.rollout", stepping / theirs, "x")


if __name__ == "__main__":
    main()
