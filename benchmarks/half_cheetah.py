"""HalfCheetah: a step and its Jacobian, beside MuJoCo's steps and its Jacobians by differences.

Ours: `step` and `differentiate` of 16 rows (and of one), states on the way of random policies.
MuJoCo's, on Gymnasium's half_cheetah.xml: the same 0.05 s as five `mj_step`, and five forward
`mjd_transitionFD` as the cost of the Jacobian of a step. States and calls take turns, and of each
the fastest of many counts: other programs can only slow one down.

Not beside nimblephysics, the closest peer (LCP contact with analytic Jacobians): its last release,
0.10.52, was built for NumPy 1, and under NumPy 2 its first vector argument ends the process.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np

from physics.randomness import generator
from physics.tasks.half_cheetah import HalfCheetah

STATES = 40
BATCH = 16


def elapsed(call: Callable[[], object]) -> float:
    """Seconds that a call takes."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def our_calls(environment: HalfCheetah, batch: int) -> tuple[list[Any], list[Any]]:
    """`step` and `differentiate` on batches along random rollouts."""
    random = generator(0, "benchmark")
    states = environment.initial_states(range(batch))
    steps, derivatives = [], []
    for index in range(5 * STATES):
        actions = random.uniform(-1.0, 1.0, (batch, 4))
        if index % 5 == 0:
            steps.append(lambda s=states, a=actions: environment.step(s, a))
            derivatives.append(lambda s=states, a=actions: environment.differentiate(s, a))
        states = environment.step(states, actions).next_state
    return steps, derivatives


def their_calls() -> tuple[list[Any], list[Any], Callable[[int], None]]:
    """Five `mj_step`, five `mjd_transitionFD`, and what sets their state."""
    path = Path(gymnasium.__file__).parent / "envs/mujoco/assets/half_cheetah.xml"
    # MuJoCo 4 deprecates this attribute, and says so in a log file; the call does the same.
    model = mujoco.MjModel.from_xml_string(path.read_text().replace('settotalmass="14"', ""))
    mujoco.mj_setTotalmass(model, 14.0)
    data, random = mujoco.MjData(model), generator(1, "benchmark")
    data.qpos[:] = random.uniform(-0.1, 0.1, 9)
    A, kept = np.zeros((18, 18)), []
    for index in range(5 * STATES):
        data.ctrl[:] = random.uniform(-1.0, 1.0, 6)
        if index % 5 == 0:
            kept.append((data.qpos.copy(), data.qvel.copy(), data.ctrl.copy()))
        mujoco.mj_step(model, data, HalfCheetah.substeps)

    def restore(index: int) -> None:
        data.qpos[:], data.qvel[:], data.ctrl[:] = kept[index]

    def step() -> None:
        mujoco.mj_step(model, data, HalfCheetah.substeps)

    def jacobian() -> None:
        for _ in range(HalfCheetah.substeps):
            mujoco.mjd_transitionFD(model, data, 1e-6, False, A, None, None, None)

    return [step] * STATES, [jacobian] * STATES, restore


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=100)
    rounds = parser.parse_args().rounds
    environment = HalfCheetah()
    print(f"HalfCheetah, compiling or loading: {environment.compile():.3g} s")
    steps, derivatives = our_calls(environment, BATCH)
    single_steps, single_derivatives = our_calls(environment, 1)
    their_steps, their_jacobians, restore = their_calls()
    kinds = [steps, derivatives, single_steps, single_derivatives, their_steps, their_jacobians]
    best = np.full((len(kinds), STATES), np.inf)
    for _ in range(rounds):
        for index in range(STATES):
            for kind, calls in enumerate(kinds):
                restore(index)
                best[kind, index] = min(best[kind, index], elapsed(calls[index]))
    step, derivative, single, single_derivative, theirs, their_jacobian = (
        1e6 * float(times.mean()) for times in best
    )
    step, derivative = step / BATCH, derivative / BATCH
    for name, value, unit in (
        ("HalfCheetah, batch 16, step", step, "us"),
        ("HalfCheetah, batch 16, differentiate", derivative, "us"),
        ("HalfCheetah, batch 1, step", single, "us"),
        ("HalfCheetah, batch 1, differentiate", single_derivative, "us"),
        ("MuJoCo half_cheetah, 5 mj_step", theirs, "us"),
        ("MuJoCo half_cheetah, 5 mjd_transitionFD", their_jacobian, "us"),
        ("HalfCheetah step over MuJoCo's", step / theirs, "x"),
        ("HalfCheetah differentiate over step", derivative / step, "x"),
        ("MuJoCo's Jacobian over HalfCheetah differentiate", their_jacobian / derivative, "x"),
    ):
        print(f"{name}: {value:.3g} {unit}")


if __name__ == "__main__":
    main()
