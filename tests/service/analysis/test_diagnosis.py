"""What is shown of diagnoses: cells by task and entry, and what figures cannot show."""

from dataclasses import replace

import pytest

from service.analysis.diagnosis import diagnosed_cells, figures_of, remarks
from service.model.diagnosis import Diagnosis
from service.model.run import Run, RunStatus
from tests.service.found import findings
from workers.messages.run_spec import RunSpec

RUN = Run(
    id="s-0", sweep_id="s", spec=RunSpec("ddpg", "Pendulum", 0), environment_version=1,
    status=RunStatus.SUCCEEDED, reason="", attempt=1, timestep=1, is_cancelling=False,
    created_at=0.0, started_at=0.0, finished_at=1.0, fingerprint=None, checkpoint_timestep=0,
    resumed_timestep=0, memory_bytes=None, entry=0, worked_seconds=0.0, score=float("nan"),
)  # fmt: skip


def made(
    algorithm: str, environment: str, seed: int, *, scale: float = 1.0, has_critic: bool = True
) -> Diagnosis:
    run = replace(RUN, id=f"{algorithm}-{seed}", spec=RunSpec(algorithm, environment, seed))
    return Diagnosis(run, findings=tuple(findings(scale, has_critic=has_critic)))


def algorithm_of(run: Run) -> str:
    """The label of a run: its entry is its algorithm."""
    return run.spec.algorithm


def test_cells_are_by_task_and_entry_and_have_the_medians_of_what_is_made() -> None:
    diagnoses = [
        made("ddpg", "Pendulum", 0, scale=1.0),
        made("ddpg", "Pendulum", 1, scale=5.0),
        made("ddpg", "Pendulum", 2, scale=2.0),
        replace(made("ddpg", "Pendulum", 3), findings=None, is_waiting=True),
        made("ddpg", "CartPole", 0),
        made("sac", "CartPole", 0),
    ]
    cells = diagnosed_cells(diagnoses, algorithm_of)
    assert [(cell.label, cell.environment, cell.seeds) for cell in cells] == [
        ("ddpg", "Pendulum", (0, 1, 2)),
        ("ddpg", "CartPole", (0,)),
        ("sac", "CartPole", (0,)),
    ]
    assert cells[0].medians["growth", "median_norm", 4, None] == pytest.approx(2.0 * 4)


def test_figures_without_a_number_are_left_out_and_it_is_said_why() -> None:
    cells = diagnosed_cells([made("gd", "Acrobot", 0, has_critic=False)], algorithm_of)
    assert list(figures_of(cells)) == ["smoothing", "growth"]
    critic, reward = remarks(cells)
    assert critic.endswith(": gd.")
    assert "Acrobot" in reward
    cells += diagnosed_cells([made("ddpg", "Acrobot", 0)], algorithm_of)
    assert list(figures_of(cells)) == ["smoothing", "growth", "critic", "loss"]
    assert list(remarks(cells)) == [critic, reward]


def test_nothing_made_is_nothing_to_show() -> None:
    assert diagnosed_cells([Diagnosis(RUN, is_waiting=True)], algorithm_of) == []
    assert figures_of([]) == {}
    assert list(remarks([])) == []
