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
from workers.journal import Journal
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


def test_the_newest_serves(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 3)
    found = checkpoints_of(tmp_path, 2).find()
    assert_serves(found, 6 * CYCLE)
    assert found.note == ""


def test_each_writes_only_what_is_new(tmp_path: Path) -> None:
    checkpoints, learner, sizes = checkpoints_of(tmp_path), FakeLearner([SPEC]), [0]
    for _ in range(3):
        train(checkpoints, learner, 1)
        sizes.append((tmp_path / "run-3" / "1.journal").stat().st_size)
    assert sizes[1] == sizes[2] - sizes[1] == sizes[3] - sizes[2]


def test_two_are_kept(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 4)
    assert names(tmp_path) == {"1.journal", "1-600.checkpoint", "1-800.checkpoint"}


def test_a_later_attempt_goes_on_from_an_earlier_ones(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 2)
    second = checkpoints_of(tmp_path, 2)
    learner = FakeLearner([SPEC])
    saved = second.find().saved
    assert saved is not None
    learner.restore({3: saved})
    train(second, learner, 2)
    assert_serves(checkpoints_of(tmp_path, 3).find(), 8 * CYCLE)
    assert names(tmp_path) == {
        *("1.journal", "2.journal"),
        *("2-600.checkpoint", "2-800.checkpoint"),
    }


@pytest.mark.parametrize("name", ["1-400.checkpoint", "1.journal"])
@pytest.mark.parametrize("damage", ["cut", "flipped"])
def test_where_the_newest_is_damaged_the_one_before_serves(
    tmp_path: Path, name: str, damage: str
) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 2)
    file = tmp_path / "run-3" / name
    whole = file.read_bytes()
    file.write_bytes(whole[:-1] + (b"" if damage == "cut" else bytes([whole[-1] ^ 1])))
    found = checkpoints_of(tmp_path, 2).find()
    assert_serves(found, 2 * CYCLE)
    assert found.note == (
        f"newest checkpoint damaged (hash mismatch of {name}), resumed from step 200"
    )


def test_where_all_are_damaged_a_run_begins_anew_and_says_so(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 2)
    (tmp_path / "run-3" / "1.journal").write_bytes(b"")
    found = checkpoints_of(tmp_path, 2).find()
    assert (found.timestep, found.saved) == (0, None)
    assert found.note == (
        "newest checkpoint damaged (hash mismatch of 1.journal), "
        "the one before damaged (hash mismatch of 1.journal), begun again from step 0"
    )
    (tmp_path / "run-3" / "1.journal").unlink()
    assert "damaged (1.journal is missing)" in checkpoints_of(tmp_path, 2).find().note


def test_a_sealed_file_of_something_else_is_refused(tmp_path: Path) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 1)
    path = tmp_path / "run-3" / f"1-{2 * CYCLE}.checkpoint"
    manifest, _, _ = sealed_file.read(path).partition(b"\n")
    for payload, told in (
        (b'{"format": 2}', "its manifest cannot be read"),
        (b'{"format": 1}', "its manifest cannot be read: its format is 1, not 2"),
        (b"[" * 100_000, "its manifest cannot be read"),
        (manifest, "no arrays but something else"),
    ):
        sealed_file.write(path, payload)
        note = checkpoints_of(tmp_path, 2).find().note
        assert note.startswith(f"newest checkpoint damaged ({told}")


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
    assert "2-600.checkpoint" in names(tmp_path)


@pytest.mark.parametrize("full", ["append", "write"])
def test_a_full_disk_costs_the_new_checkpoint_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, full: str
) -> None:
    """Whichever of its two files does not fit."""
    checkpoints = checkpoints_of(tmp_path)
    learner = train(checkpoints, FakeLearner([SPEC]), 2)
    before = names(tmp_path)

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patched:
        patched.setattr({"append": Journal, "write": sealed_file}[full], full, fail)
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
