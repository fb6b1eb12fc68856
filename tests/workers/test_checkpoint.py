"""Checkpoints: the newest whole one serves, and what is said where it is not the newest."""

import errno
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from algorithms.learner import Learner
from algorithms.measurement import Measurement
from algorithms.policy import deterministic
from algorithms.snapshot import Critic, Snapshot
from tests.workers.fake_learner import CYCLE, FakeLearner, measurement_of
from workers import sealed_file
from workers.assignment import Assignment
from workers.checkpoint import Checkpoints, Found, find_epochs, find_snapshot
from workers.checkpoint_folder import remove_checkpoints
from workers.run_spec import RunSpec

SPEC = RunSpec("fake", "Pendulum", 3, timesteps=10_000)
FINGERPRINT = {"code": "abc", "processor": "AVX512"}


def checkpoints_of(
    root: Path,
    attempt: int = 1,
    spec: RunSpec = SPEC,
    fingerprint: Mapping[str, Any] = FINGERPRINT,
) -> Checkpoints:
    return Checkpoints(root, Assignment("run-3", attempt, spec), fingerprint)


def train(checkpoints: Checkpoints, learner: FakeLearner, saves: int) -> FakeLearner:
    """Train two cycles and save, so many times."""
    for _ in range(saves):
        learner.advance()
        learner.advance()
        checkpoints.save(learner, points(learner.timestep))
    return learner


def points(timestep: int) -> list[Measurement]:
    return [measurement_of(3, step) for step in range(CYCLE, timestep + 1, CYCLE)]


def assert_serves(found: Found, timestep: int) -> None:
    """A learner that is taken up there checks its own state and journal."""
    assert found.timestep == timestep
    assert list(found.measurements) == points(timestep)
    assert found.saved is not None
    learner: Learner = FakeLearner([SPEC])
    learner.restore({3: found.saved})
    assert learner.timestep == timestep


def names(root: Path) -> set[str]:
    return {path.name for path in (root / "run-3").iterdir()}


def test_without_a_checkpoint_a_run_begins_anew(tmp_path: Path) -> None:
    assert checkpoints_of(tmp_path).find() == Found()


def test_the_newest_serves_and_each_wrote_only_what_was_new(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 3)
    found = checkpoints_of(tmp_path, 2).find()
    assert_serves(found, 6 * CYCLE)
    assert found.note == ""
    sizes = [(tmp_path / "run-3" / f"1-{n * CYCLE}.journal").stat().st_size for n in (2, 4, 6)]
    assert sizes[0] == sizes[1] == sizes[2]


def test_two_are_kept(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 4)
    assert names(tmp_path) == {
        *(f"1-{n * CYCLE}.journal" for n in (2, 4, 6, 8)),
        *(f"1-{n * CYCLE}.{kind}" for n in (6, 8) for kind in ("state", "manifest")),
    }


def test_a_later_attempt_goes_on_from_an_earlier_ones(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 2)
    second = checkpoints_of(tmp_path, 2)
    learner = FakeLearner([SPEC])
    saved = second.find().saved
    assert saved is not None
    learner.restore({3: saved})
    train(second, learner, 2)
    assert_serves(checkpoints_of(tmp_path, 3).find(), 8 * CYCLE)
    assert "1-200.journal" in names(tmp_path)
    assert "1-400.manifest" not in names(tmp_path)


@pytest.mark.parametrize("kind", ["manifest", "state", "journal"])
def test_where_the_newest_is_damaged_the_one_before_serves(tmp_path: Path, kind: str) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 2)
    part = tmp_path / "run-3" / f"1-{4 * CYCLE}.{kind}"
    part.write_bytes(part.read_bytes()[:-1])
    found = checkpoints_of(tmp_path, 2).find()
    assert_serves(found, 2 * CYCLE)
    assert found.note == (
        f"newest checkpoint damaged (hash mismatch of 1-400.{kind}), resumed from step 200"
    )
    part.unlink()
    if kind != "manifest":
        note = f"newest checkpoint damaged (1-400.{kind} is missing), resumed from step 200"
        assert checkpoints_of(tmp_path, 2).find().note == note


def test_where_all_are_damaged_a_run_begins_anew_and_says_so(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 2)
    (tmp_path / "run-3" / f"1-{2 * CYCLE}.journal").write_bytes(b"")
    found = checkpoints_of(tmp_path, 2).find()
    assert (found.timestep, found.saved) == (0, None)
    assert found.note == (
        "newest checkpoint damaged (hash mismatch of 1-200.journal), "
        "the one before damaged (hash mismatch of 1-200.journal), begun again from step 0"
    )


def test_a_sealed_file_of_something_else_is_refused(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 1)
    sealed_file.write(tmp_path / "run-3" / f"1-{2 * CYCLE}.manifest", b'{"format": 1}')
    note = checkpoints_of(tmp_path, 2).find().note
    assert note.startswith("newest checkpoint damaged (its manifest cannot be read")


def test_a_checkpoint_of_another_spec_is_refused(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 2)
    found = checkpoints_of(tmp_path, 2, replace(SPEC, timesteps=20_000)).find()
    assert found == Found(note="its checkpoint is of another spec, begun again from step 0")


def test_a_checkpoint_of_other_code_is_refused(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 2)
    found = checkpoints_of(tmp_path, 2, fingerprint={**FINGERPRINT, "code": "def"}).find()
    assert found == Found(note="its checkpoint was made by other code, begun again from step 0")


def test_a_checkpoint_of_another_machine_serves_and_the_mark_stays(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 1)
    second = checkpoints_of(tmp_path, 2, fingerprint={**FINGERPRINT, "processor": "AVX2"})
    found = second.find()
    assert_serves(found, 2 * CYCLE)
    assert found.note == "not bit-comparable: processor was AVX512, now AVX2"
    learner = FakeLearner([SPEC])
    assert found.saved is not None
    learner.restore({3: found.saved})
    train(second, learner, 1)
    third = checkpoints_of(tmp_path, 3, fingerprint={**FINGERPRINT, "processor": "AVX2"}).find()
    assert third.mixed_with == ["processor was AVX512, now AVX2"]


def test_one_that_was_given_up_disturbs_none_of_its_successor(tmp_path: Path) -> None:
    first = checkpoints_of(tmp_path)
    orphan = train(first, FakeLearner([SPEC]), 2)
    second = checkpoints_of(tmp_path, 2)
    learner = FakeLearner([SPEC])
    saved = second.find().saved
    assert saved is not None
    learner.restore({3: saved})
    train(second, learner, 1)
    train(first, orphan, 3)
    assert_serves(checkpoints_of(tmp_path, 3).find(), 6 * CYCLE)
    assert "2-600.manifest" in names(tmp_path)


@pytest.mark.parametrize("call", range(3))
def test_a_full_disk_costs_the_new_checkpoint_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: int
) -> None:
    """Whichever of its three files does not fit."""
    checkpoints = checkpoints_of(tmp_path)
    learner = train(checkpoints, FakeLearner([SPEC]), 2)
    before = names(tmp_path)
    write, calls = sealed_file.write, []

    def full(path: Path, payload: bytes) -> str:
        calls.append(path)
        if len(calls) > call:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(path, payload)

    with monkeypatch.context() as patched:
        patched.setattr(sealed_file, "write", full)
        with pytest.raises(OSError, match="No space left"):
            train(checkpoints, learner, 1)
    assert names(tmp_path) == before
    assert_serves(checkpoints_of(tmp_path, 2).find(), 4 * CYCLE)
    train(checkpoints, learner, 1)
    assert_serves(checkpoints_of(tmp_path, 2).find(), 8 * CYCLE)


def test_what_was_learned_outlives_the_checkpoints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    theta, unit = np.arange(5, dtype=np.float32), np.ones(3, np.float32)
    learned = Snapshot(200, 8, 1, deterministic(theta, unit, unit, 1), Critic(theta, -3.5, 2.5))
    monkeypatch.setattr(FakeLearner, "snapshot", lambda self, seed: learned)
    checkpoints = checkpoints_of(tmp_path)
    assert find_snapshot(tmp_path, "run-3") is None
    checkpoints.save_policy(train(checkpoints, FakeLearner([SPEC]), 2))
    remove_checkpoints(tmp_path, "run-3")
    assert names(tmp_path) == {"policy"}
    remove_checkpoints(tmp_path, "run-3")
    remove_checkpoints(tmp_path, "run-4")
    found = find_snapshot(tmp_path, "run-3")
    assert found is not None
    assert (found.timestep, found.hidden, found.actions) == (200, 8, 1)
    np.testing.assert_array_equal(found.policy.theta, theta, strict=True)
    assert found.critic is not None
    assert (found.critic.value_mean, found.critic.value_std) == (-3.5, 2.5)


def test_on_the_mass_point_what_was_learned_by_the_epochs_of_figure_2_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    theta, unit = np.arange(5, dtype=np.float32), np.ones(3, np.float32)

    def learned(self: FakeLearner, seed: int) -> Snapshot:
        return Snapshot(self.timestep, 8, 1, deterministic(theta, unit, unit, 1))

    monkeypatch.setattr(FakeLearner, "snapshot", learned)
    for spec, kept in ((replace(SPEC, environment="MassPoint"), [1, 10]), (SPEC, [])):
        root = tmp_path / spec.environment
        checkpoints, learner = checkpoints_of(root, spec=spec), FakeLearner([spec])
        while not learner.finished:
            learner.advance()
            checkpoints.save_epoch(learner)
        found = find_epochs(root, "run-3")
        assert {epoch: each.timestep for epoch, each in found.items()} == {
            epoch: 800 * epoch for epoch in kept
        }


def test_a_runs_name_is_no_path(tmp_path: Path) -> None:
    for name in ("", "..", "a/b", "/etc"):
        with pytest.raises(ValueError, match="is no path"):
            find_snapshot(tmp_path, name)
