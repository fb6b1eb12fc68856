"""Policy file: what a run has learned, as a file to act with (algorithms.acting.policy_file)."""

import physics
from algorithms.acting.policy import policy_of
from algorithms.acting.policy_file import policy_bytes
from workers.checkpoints.checkpoint import find_snapshot
from workers.checkpoints.place import Place
from workers.messages.run_spec import RunSpec


def policy_file(checkpoints: Place, run_id: str, spec: RunSpec) -> bytes | None:
    """The content of the file; None while the run has learned nothing that was written.

    Raises:
        DamagedError: where what was learned cannot be read.
        UnavailableError: where the place of the checkpoints cannot be had.
    """
    snapshot = find_snapshot(checkpoints, run_id)
    if snapshot is None:
        return None
    origin = {
        "run": run_id,
        "algorithm": spec.algorithm,
        "weights": list(spec.weights),
        "config": dict(spec.config),
        "seed": spec.seed,
    }
    return policy_bytes(policy_of(snapshot, physics.make(spec.environment), origin))
