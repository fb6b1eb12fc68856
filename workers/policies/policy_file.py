"""Policy file: what a run has learned, as a file to act with (algorithms.acting.policy_file)."""

from algorithms.acting.policy import policy_of
from algorithms.acting.policy_file import policy_bytes
from physics.task_file import TaskFile
from workers.checkpoints.checkpoint import find_snapshot
from workers.checkpoints.place import Place
from workers.messages.run_spec import RunSpec
from workers.policies.task import task_of


def policy_file(
    checkpoints: Place, run_id: str, spec: RunSpec, file: TaskFile | None = None
) -> bytes | None:
    """The content of the file; None while the run has learned nothing that was written.

    `file` is the text of the task, where the task is of one.

    Raises:
        DamagedError: where what was learned cannot be read.
        UnavailableError: if the place of the checkpoints is unavailable.
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
    return policy_bytes(policy_of(snapshot, task_of(spec, file), origin))
