"""Memory of workers: what they may fill, and how many runs that are."""

from dataclasses import replace
from pathlib import Path

import pytest

from service.queue import worker_memory
from service.queue.worker_memory import machine_memory, memory_of, runs_at_once, usual_worker_memory
from workers.messages.run_spec import COHORT_LIMIT, RunSpec, Weights

CELL = RunSpec("hybrid-ddpg", "HalfCheetah", 0, Weights(0.1, 0.01), 200_000).cell


def test_a_cohort_is_cut_so_that_it_fits() -> None:
    each = memory_of(CELL)
    assert each == 253_600_000
    for budget in (each, 5 * each, 5 * each + each // 2, 100 * each):
        runs = runs_at_once(CELL, budget)
        assert runs * each <= budget
        assert runs == COHORT_LIMIT or (runs + 1) * each > budget


def test_one_that_is_too_large_is_taken_alone() -> None:
    assert runs_at_once(CELL, memory_of(CELL) - 1) == 1


def test_what_cannot_be_worked_out_is_left_to_the_worker() -> None:
    assert runs_at_once(replace(CELL, algorithm="uninstalled"), 1) == COHORT_LIMIT
    assert runs_at_once(replace(CELL, config={"replay_size": "x"}), 1) == COHORT_LIMIT


def test_workers_share_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker_memory, "machine_memory", lambda: 16 * 2**30)
    assert usual_worker_memory(2) == int(6.4 * 2**30) - 300 * 2**20
    for workers in (1, 2, 8, 64, 4096):
        assert 0 < workers * usual_worker_memory(workers) <= 16 * 2**30


def test_a_container_may_use_no_more_than_its_limit(tmp_path: Path) -> None:
    limit = tmp_path / "memory.max"
    physical = machine_memory(limit)
    limit.write_text("max\n")
    assert machine_memory(limit) == physical
    limit.write_text("1073741824\n")
    assert machine_memory(limit) == 2**30
