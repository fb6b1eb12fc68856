"""Robots: a step and its Jacobian, compared with MuJoCo's steps and Jacobians by differences.

The robots are HalfCheetah, Hopper and Walker2d. Ours are `step` and `differentiate` of 16 rows (and
of one), in states of random policies. MuJoCo's, on Gymnasium's models, are as many `mj_step` as a
step has substeps, of the same length, and as many forward `mjd_transitionFD` for the cost of a
step's Jacobian. There, Hopper and Walker2d have the Runge-Kutta integrator; MuJoCo's steps are also
measured with Euler's, and its Jacobians only with Euler's, since it has no others. States and calls
take turns, and the fastest of many counts for each: other programs can only slow one down.

nimblephysics, the closest peer (LCP contact with analytic Jacobians), is not included: its last
release, 0.10.52, was built for NumPy 1, and under NumPy 2 its first vector argument ends the
process.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np

from physics.environment import FloatArray
from physics.randomness import generator
from physics.robots.task import RobotTask
from physics.tasks.half_cheetah import HalfCheetah
from physics.tasks.hopper import Hopper
from physics.tasks.walker2d import Walker2d

STATES = 40
BATCH = 16
FILES: dict[type[RobotTask], str] = {
    HalfCheetah: "half_cheetah.xml",
    Hopper: "hopper.xml",
    Walker2d: "walker2d_v5.xml",
}


def elapsed(call: Callable[[], object]) -> float:
    """The seconds of a call."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def begun_again(environment: RobotTask, following: FloatArray, ends: Any) -> FloatArray:
    """The next states, with start states for episodes that have ended."""
    following = following.copy()
    following[ends] = environment.initial_states(np.flatnonzero(ends))
    return following


def our_calls(environment: RobotTask, batch: int) -> tuple[list[Any], list[Any]]:
    """`step` and `differentiate` on batches along random rollouts."""
    random = generator(0, "benchmark")
    states = environment.initial_states(range(batch))
    steps, derivatives = [], []
    for index in range(5 * STATES):
        actions = random.uniform(-1.0, 1.0, (batch, environment.action_size))
        if index % 5 == 0:
            steps.append(lambda s=states, a=actions: environment.step(s, a))
            derivatives.append(lambda s=states, a=actions: environment.differentiate(s, a))
        following, _, ends = environment.step(states, actions)
        states = begun_again(environment, following, ends)
    return steps, derivatives


def their_model(environment: RobotTask) -> Any:
    """Gymnasium's."""
    path = Path(gymnasium.__file__).parent / "envs/mujoco/assets" / FILES[type(environment)]
    # MuJoCo 4 deprecates this attribute, and says so in a log file; the call does the same.
    text = path.read_text()
    model = mujoco.MjModel.from_xml_string(text.replace('settotalmass="14"', ""))
    if "settotalmass" in text:
        mujoco.mj_setTotalmass(model, 14.0)
    assert model.opt.timestep == environment.substep_seconds
    return model


def their_calls(environment: RobotTask) -> tuple[list[list[Any]], Callable[[int], None]]:
    """The peer's calls, and a function that sets their state.

    Each call does `mj_step` (with the model's integrator, or with Euler's) or `mjd_transitionFD`
    once per substep.
    """
    model, random = their_model(environment), generator(1, "benchmark")
    data, substeps, size = mujoco.MjData(model), environment.substeps, 2 * model.nv
    A, kept = np.zeros((size, size)), []
    for index in range(5 * STATES):
        if index % 20 == 0:
            mujoco.mj_resetData(model, data)
            data.qpos[:] += random.uniform(-5e-3, 5e-3, model.nq)
        data.ctrl[:] = random.uniform(-1.0, 1.0, model.nu)
        if index % 5 == 0:
            kept.append((data.qpos.copy(), data.qvel.copy(), data.ctrl.copy()))
        mujoco.mj_step(model, data, substeps)

    def restore(index: int) -> None:
        data.qpos[:], data.qvel[:], data.ctrl[:] = kept[index]

    integrator = model.opt.integrator

    def step() -> None:
        model.opt.integrator = integrator
        mujoco.mj_step(model, data, substeps)

    def euler() -> None:
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        mujoco.mj_step(model, data, substeps)

    def jacobian() -> None:
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        for _ in range(substeps):
            mujoco.mjd_transitionFD(model, data, 1e-6, False, A, None, None, None)

    return [[call] * STATES for call in (step, euler, jacobian)], restore


def measure(environment: RobotTask, rounds: int) -> None:
    """Print all figures of one robot."""
    name, substeps = environment.name, environment.substeps
    print(f"{name}, compiling or loading: {environment.compile():.3g} s")
    theirs, restore = their_calls(environment)
    ours = [calls for batch in (BATCH, 1) for calls in our_calls(environment, batch)]
    kinds = [*ours, *theirs]
    best = np.full((len(kinds), STATES), np.inf)
    for _ in range(rounds):
        for index in range(STATES):
            for kind, calls in enumerate(kinds):
                restore(index)
                best[kind, index] = min(best[kind, index], elapsed(calls[index]))
    step, derivative, single, single_derivative, their_step, euler, their_jacobian = (
        1e6 * float(times.mean()) for times in best
    )
    step, derivative = step / BATCH, derivative / BATCH
    for what, value, unit in (
        (f"{name}, batch 16, step", step, "us"),
        (f"{name}, batch 16, differentiate", derivative, "us"),
        (f"{name}, batch 1, step", single, "us"),
        (f"{name}, batch 1, differentiate", single_derivative, "us"),
        (f"MuJoCo {name}, {substeps} mj_step", their_step, "us"),
        (f"MuJoCo {name}, {substeps} mj_step of Euler's", euler, "us"),
        (f"MuJoCo {name}, {substeps} mjd_transitionFD", their_jacobian, "us"),
        (f"{name} step over MuJoCo's", step / their_step, "x"),
        (f"{name} step over MuJoCo's of Euler's", step / euler, "x"),
        (f"{name} differentiate over step", derivative / step, "x"),
        (f"MuJoCo's Jacobian over {name} differentiate", their_jacobian / derivative, "x"),
    ):
        print(f"{what}: {value:.3g} {unit}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=100)
    rounds = parser.parse_args().rounds
    for task in FILES:
        measure(task(), rounds)


if __name__ == "__main__":
    main()
