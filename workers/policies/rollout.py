"""Rollout: an episode of what a run has learned, as data to draw and play."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.snapshot import Snapshot
from physics.environment import Environment, UnsolvedStepError
from physics.film import film
from physics.task_file import TaskFile
from workers.checkpoints.checkpoint import find_snapshot
from workers.checkpoints.checkpoint_folder import SURFACE_TASK
from workers.checkpoints.place import Place
from workers.messages.run_spec import RunSpec
from workers.policies.critic_surface import critic_surface, discount_of
from workers.policies.episode import play
from workers.policies.start_error import StartError
from workers.policies.task import task_of

FloatArray = NDArray[np.float64]


def rollout(
    checkpoints: Place,
    run_id: str,
    spec: RunSpec,
    file: TaskFile | None,
    start: list[float] | int,
) -> dict[str, Any] | None:
    """Play a run's policy from a start state [n], or from the task's start of a seed.

    `file` is the text of the task, where the task is of one.

    None while the run has learned nothing that was written. `service.api.schemas.rollout_answer`
    describes the fields.

    Raises:
        StartError: for a state that is none of the task's.
        DamagedError: where what was learned cannot be read.
        UnavailableError: if the place of the checkpoints is unavailable.
    """
    snapshot = find_snapshot(checkpoints, run_id)
    if snapshot is None:
        return None
    task = task_of(spec, file)
    try:
        episode = play(task, snapshot.policies(), start_state(task, start))
    except (ValueError, UnsolvedStepError) as refusal:
        raise StartError(str(refusal)) from refusal
    contacts = task.contact_impulses(episode.states[:-1], episode.actions)
    return {
        "environment": spec.environment,
        "timestep": snapshot.timestep,
        "dt": task.step_seconds,
        "states": episode.states.tolist(),
        "actions": episode.actions.tolist(),
        "rewards": episode.rewards.tolist(),
        "terminated": episode.terminated,
        "contacts": [impulses.tolist() for impulses in contacts],
        "surface": surface(task, snapshot, spec),
        **film([task.draw(state) for state in episode.states]),
    }


def start_state(task: Environment, start: list[float] | int) -> FloatArray:
    """The state [n]. Raises StartError for one of another size."""
    if isinstance(start, int):
        return np.asarray(task.initial_states([start])[0])
    if len(start) != task.state_size:
        raise StartError(f"a state of {task.name} has {task.state_size} numbers, got {len(start)}")
    return np.array(start, np.float64)


def surface(task: Environment, snapshot: Snapshot, spec: RunSpec) -> dict[str, Any] | None:
    """MassPoint's critic and the truth (figure 2); None for other tasks and without a critic."""
    if task.name != SURFACE_TASK or snapshot.critic is None:
        return None
    exact = task.with_parameters(process_noise=0.0, observation_noise=0.0)
    found = critic_surface(exact, snapshot, discount_of(spec))
    return {name: values.tolist() for name, values in found._asdict().items()}
