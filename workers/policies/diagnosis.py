"""Diagnosis: where the simulator's gradients help a run, found in what it has learned."""

from algorithms.diagnostics.diagnose import diagnose
from algorithms.diagnostics.finding import Finding
from physics.task_file import TaskFile
from workers.checkpoints.checkpoint import find_snapshot
from workers.checkpoints.place import Place
from workers.messages.run_spec import RunSpec
from workers.policies.critic_surface import discount_of
from workers.policies.task import task_of


def diagnosis(
    checkpoints: Place, run_id: str, spec: RunSpec, file: TaskFile | None
) -> list[Finding] | None:
    """Diagnose a run, whose task is that of a file where there is one.

    Finds the same numbers as `python -m algorithms diagnose` of its seed.

    None while the run has learned nothing that was written.

    Raises:
        ArithmeticError: where a step has no derivatives, or no solution.
        DamagedError: where what was learned cannot be read.
        UnavailableError: if the place of the checkpoints is unavailable.
    """
    snapshot = find_snapshot(checkpoints, run_id)
    if snapshot is None:
        return None
    gamma = None if snapshot.critic is None else discount_of(spec)
    return diagnose(task_of(spec, file), snapshot, gamma, spec.seed)
