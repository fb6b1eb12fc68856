"""Two measured runs: a diagnostic that one of them lacks, and a value that is not finite."""

import numpy as np

from service.export.measured_run import MeasuredRun


def run(seed: int, points: int = 3, **columns: list[float]) -> MeasuredRun:
    steps = 800.0 * np.arange(1, points + 1)
    own = {"timestep": steps, "return_mean": -steps / 100, "seconds": steps / 1000}
    given = {name: np.array(values) for name, values in columns.items()}
    return MeasuredRun(
        id=f"3f9a0c51b7de-{seed}",
        label="ddpg noise=0.1",
        algorithm="ddpg",
        environment="Pendulum(gravity=8)",
        w1=0.0,
        w2=0.0,
        config={"noise": 0.1},
        seed=seed,
        columns=own | given,
    )


def two_runs() -> list[MeasuredRun]:
    return [run(0, critic_loss=[1.0, float("nan"), 2.5]), run(1, points=2)]
