"""The record of the audit: of these versions, passed, and not stale."""

from pathlib import Path

import pytest

import physics
from physics.audit.audit import audit
from physics.audit.record import RegimeAudit, as_table, audited, read_record, write_record
from physics.catalogue import OWN


def test_the_record_keeps_other_tasks(tmp_path: Path) -> None:
    path = tmp_path / "audit.json"
    old = RegimeAudit("CartPole", 1, "free", 2000, 1, 1e-8, 1e-12)
    write_record([RegimeAudit("Pendulum", 1, "free", 10, 0, 1e-9, 1e-12), old], path)
    write_record([RegimeAudit("Pendulum", 2, "free", 20, 0, 1e-9, 1e-12)], path)
    assert [(row.environment, row.states) for row in read_record(path)] == [
        ("CartPole", 2000),
        ("Pendulum", 20),
    ]
    assert read_record(path)[0] == old
    assert "| Pendulum | 2 | free | 20 | 0 | 1.0e-09 | 1.0e-12 |" in as_table(read_record(path))


@pytest.mark.parametrize("name", OWN)
def test_the_record_has_every_regime_of_this_version(name: str) -> None:
    task = physics.make(name)
    rows = audited(name, task.version)
    assert [row.regime for row in rows] == list(task.regimes), f"audit {name} anew"
    assert all(row.passed() for row in rows), as_table(rows)
    assert audited(name, task.version + 1) == []


def test_the_record_is_of_this_code() -> None:
    """The audit is a pure function of the code and its seed: a quick task's says the same again."""
    task = physics.make("MountainCar")
    for kept, now in zip(audited("MountainCar", task.version), audit(task), strict=True):
        assert (kept.regime, kept.states, kept.kinks) == (now.regime, now.states, now.kinks)
        assert now.median == pytest.approx(kept.median, rel=0.5)
