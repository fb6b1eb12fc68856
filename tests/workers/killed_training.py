"""Training that is killed and taken up again, over and over; run by `test_kills`.

Every attempt is a process of its own, forked off one that has compiled all kernels, and ended by
SIGKILL at a random moment: while it looks for checkpoints, trains, or writes one (it writes one
after every cycle).
"""

import hashlib
import json
import math
import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from algorithms.early_end import Divergence
from algorithms.learner import Learner
from algorithms.state import State
from workers.checkpoints.place import Place
from workers.messages.assignment import Assignment
from workers.messages.run_spec import RunSpec, Weights
from workers.training import cadence
from workers.training.execute import execute, learner_of_cohort

REDRAWN = 3
"""Trials are drawn so often, until enough of them were killed alive, twice."""


def train(specs: Sequence[RunSpec], root: Place, attempt: int, result: Path) -> None:
    """Train a cohort to its end, and write where it began and the digest of all it came to."""
    learners: dict[int, Learner] = {}

    def keep(asked: Sequence[RunSpec]) -> Learner:
        learner = learner_of_cohort(asked)
        learners.update({spec.seed: learner for spec in asked})
        return learner

    runs = [Assignment(f"run-{spec.seed}", attempt, spec, 1) for spec in specs]
    said = list(execute(runs, root, tuple, os.abort, build_learner=keep))
    begun = [resumption.timestep for progress in said for resumption in progress.resumed]
    measured = {
        (m.seed, m.timestep): (repr(m.return_mean), repr(m.return_history), repr(m.diagnostics))
        for progress in said
        for m in progress.measurements
    }
    digest = hashlib.sha256(repr(sorted(measured.items())).encode())
    for seed, learner in sorted(learners.items()):
        for name, array in sorted(came_to(learner, seed).items()):
            if name not in {"seconds", "compile_seconds"}:
                digest.update(f"{seed} {name}".encode() + array.tobytes())
    assert not any(isinstance(d, Divergence) for progress in said for d in progress.diverged)
    result.write_text(json.dumps({"begun": begun, "digest": digest.hexdigest()}))


def came_to(learner: Learner, seed: int) -> State:
    """What a run that has ended learned; where it has not left the learner, all that it is."""
    snapshot = learner.snapshot(seed)
    learned = {} if snapshot is None else snapshot.arrays()
    if seed not in learner.seeds:
        return learned
    return {**learned, **learner.state(seed), **learner.journal(seed, 0)}


def die_at_random(draw: random.Random, pid: int, seconds: float) -> bool:
    """Kill an attempt at a moment of the time that a whole run takes; was it still alive?"""
    time.sleep(draw.uniform(0.1, 0.7) * seconds)
    os.kill(pid, signal.SIGKILL)
    _, status = os.waitpid(pid, 0)
    return os.WIFSIGNALED(status)


def fork(specs: Sequence[RunSpec], root: Place, attempt: int, result: Path) -> int:
    """Start an attempt; its process id."""
    if pid := os.fork():
        return pid
    try:
        train(specs, root, attempt, result)
    finally:
        os._exit(0 if result.exists() else 1)


def main(algorithm: str, environment: str, timesteps: int, trials: int, place: str) -> None:
    """Kill each trial twice, alive, and print what came of them all.

    All checkpoints lie below the place but those of the run that compiles: forks and the threads of
    a bucket's client do not go together.
    """
    cadence.SHORTEST_SECONDS, cadence.SHARE = 0.0, math.inf
    specs = [RunSpec(algorithm, environment, seed, Weights(), timesteps) for seed in (0, 1)]
    if algorithm.startswith("hybrid"):
        specs = [
            RunSpec(s.algorithm, s.environment, s.seed, Weights(0.1, 0.01), timesteps)
            for s in specs
        ]
    draw = random.Random(algorithm)  # noqa: S311
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        root = place or folder
        train(specs, scratch / "compiled", 1, scratch / "compiled.json")
        begun = time.monotonic()
        os.waitpid(fork(specs, f"{root}/whole", 1, scratch / "whole.json"), 0)
        seconds = time.monotonic() - begun
        whole = json.loads((scratch / "whole.json").read_text())
        killed = equal = resumed = drawn = 0
        while killed < trials and drawn < REDRAWN * trials:
            drawn += 1
            trial, result = f"{root}/{drawn}", scratch / f"{drawn}.json"
            if not all(
                die_at_random(draw, fork(specs, trial, attempt, result), seconds)
                for attempt in (1, 2)
            ):
                continue  # it had come to its end before it could be killed
            os.waitpid(fork(specs, trial, 3, result), 0)
            end = json.loads(result.read_text())
            killed += 1
            equal += end["digest"] == whole["digest"]
            resumed += min(end["begun"]) > 0
        found = {"killed": killed, "equal": equal, "resumed": resumed, "seconds": seconds}
        print(json.dumps(found))  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), sys.argv[5])
