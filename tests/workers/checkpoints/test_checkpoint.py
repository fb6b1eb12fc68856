"""Checkpoints: the newest whole one serves, and what is said where it is not the newest."""

import errno
import hashlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from algorithms.learner import Learner
from algorithms.measurement import Measurement
from algorithms.networks.policy import deterministic
from algorithms.snapshot import Critic, Inside, Snapshot
from tests.object_store import objects
from tests.workers.fake_learner import CYCLE, FakeLearner, measurement_of
from workers.checkpoints import sealed_file
from workers.checkpoints.bucket import SCHEME
from workers.checkpoints.bucket_folder import PIECE
from workers.checkpoints.checkpoint import Checkpoints, Found, find_epochs, find_snapshot
from workers.checkpoints.checkpoint_folder import newest_first, remove_checkpoints
from workers.checkpoints.disk_folder import DiskFolder
from workers.checkpoints.folder import UnavailableError, UnreachableError
from workers.checkpoints.journal import Journal
from workers.checkpoints.manifest import Manifest
from workers.checkpoints.place import Place, folder_in
from workers.messages.assignment import Assignment
from workers.messages.run_spec import RunSpec

SPEC = RunSpec("fake", "Pendulum", 3, timesteps=10_000)
FINGERPRINT = {"code": "abc", "processor": "AVX512"}


def checkpoints_of(
    place: Place,
    attempt: int = 1,
    spec: RunSpec = SPEC,
    fingerprint: Mapping[str, Any] = FINGERPRINT,
) -> Checkpoints:
    return Checkpoints(place, Assignment("run-3", attempt, spec, 1), fingerprint)


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


def names(place: Place) -> set[str]:
    return set(folder_in(place, "run-3").names())


def damage(place: Place, name: str, change: Callable[[bytes], bytes]) -> None:
    """Change a file, or the last of the objects that it is."""
    if isinstance(place, Path):
        file = place / "run-3" / name
        file.write_bytes(change(file.read_bytes()))
    else:
        found = objects().find(place.removeprefix(SCHEME), prefix=f"run-3/{name}")
        pieces = {key: PIECE.fullmatch(key) for key in found}
        key = max(found, key=lambda key: int(each["stop"]) if (each := pieces[key]) else 0)
        objects().pipe_file(key, change(objects().cat_file(key)))


def test_without_a_checkpoint_a_run_begins_anew(place: Place) -> None:
    assert checkpoints_of(place).find() == Found()


def test_the_newest_serves(place: Place) -> None:
    train(checkpoints_of(place), FakeLearner([SPEC]), 3)
    found = checkpoints_of(place, 2).find()
    assert_serves(found, 6 * CYCLE)
    assert found.note == ""


def test_each_writes_only_what_is_new(place: Place) -> None:
    checkpoints, learner, sizes = checkpoints_of(place), FakeLearner([SPEC]), [0]
    folder = folder_in(place, "run-3")
    for _ in range(3):
        train(checkpoints, learner, 1)
        sealed = sealed_file.read(folder, newest_first(folder)[0])
        [journal] = Manifest.from_text(sealed.partition(b"\n")[0]).journal
        assert len(folder.read_beginning("1.journal", journal.size)) == journal.size
        sizes.append(journal.size)
    assert sizes[1] == sizes[2] - sizes[1] == sizes[3] - sizes[2]


def test_two_are_kept(place: Place) -> None:
    train(checkpoints_of(place), FakeLearner([SPEC]), 4)
    assert names(place) == {"1.journal", "1-600.checkpoint", "1-800.checkpoint"}


def test_a_later_attempt_goes_on_from_an_earlier_ones(place: Place) -> None:
    train(checkpoints_of(place), FakeLearner([SPEC]), 2)
    second = checkpoints_of(place, 2)
    learner = FakeLearner([SPEC])
    saved = second.find().saved
    assert saved is not None
    learner.restore({3: saved})
    train(second, learner, 2)
    assert_serves(checkpoints_of(place, 3).find(), 8 * CYCLE)
    assert names(place) == {
        *("1.journal", "2.journal"),
        *("2-600.checkpoint", "2-800.checkpoint"),
    }


@pytest.mark.parametrize("name", ["1-400.checkpoint", "1.journal"])
@pytest.mark.parametrize("how", ["cut", "flipped"])
def test_where_the_newest_is_damaged_the_one_before_serves(
    place: Place, name: str, how: str
) -> None:
    train(checkpoints_of(place), FakeLearner([SPEC]), 2)
    damage(
        place,
        name,
        lambda whole: whole[:-1] + (b"" if how == "cut" else bytes([whole[-1] ^ 1])),
    )
    found = checkpoints_of(place, 2).find()
    assert_serves(found, 2 * CYCLE)
    assert found.note == (
        f"newest checkpoint damaged (hash mismatch of {name}), resumed from step 200"
    )


def test_where_all_are_damaged_a_run_begins_anew_and_says_so(tmp_path: Path) -> None:
    place = tmp_path
    train(checkpoints_of(place), FakeLearner([SPEC]), 2)
    (place / "run-3" / "1.journal").write_bytes(b"")
    found = checkpoints_of(place, 2).find()
    assert (found.timestep, found.saved) == (0, None)
    assert found.note == (
        "newest checkpoint damaged (hash mismatch of 1.journal), "
        "the one before damaged (hash mismatch of 1.journal), begun again from step 0"
    )
    (place / "run-3" / "1.journal").unlink()
    assert "damaged (1.journal is missing)" in checkpoints_of(place, 2).find().note


def test_a_sealed_file_of_something_else_is_refused(place: Place) -> None:
    train(checkpoints_of(place), FakeLearner([SPEC]), 1)
    folder, name = folder_in(place, "run-3"), f"1-{2 * CYCLE}.checkpoint"
    manifest, _, _ = sealed_file.read(folder, name).partition(b"\n")
    for payload, told in (
        (b'{"format": 2}', "its manifest cannot be read"),
        (b'{"format": 1}', "its manifest cannot be read: its format is 1, not 2"),
        (b"[" * 100_000, "its manifest cannot be read"),
        (manifest, "not arrays, refused"),
    ):
        sealed_file.write(folder, name, payload)
        note = checkpoints_of(place, 2).find().note
        assert note.startswith(f"newest checkpoint damaged ({told}")


def test_a_checkpoint_of_another_spec_is_refused(place: Place) -> None:
    train(checkpoints_of(place), FakeLearner([SPEC]), 2)
    found = checkpoints_of(place, 2, replace(SPEC, timesteps=20_000)).find()
    assert found == Found(note="its checkpoint is of another spec, begun again from step 0")


def test_a_checkpoint_of_other_code_is_refused(place: Place) -> None:
    train(checkpoints_of(place), FakeLearner([SPEC]), 2)
    found = checkpoints_of(place, 2, fingerprint={**FINGERPRINT, "code": "def"}).find()
    assert found == Found(note="its checkpoint was made by other code, begun again from step 0")


def test_a_checkpoint_of_another_machine_serves_and_the_mark_stays(place: Place) -> None:
    train(checkpoints_of(place), FakeLearner([SPEC]), 1)
    second = checkpoints_of(place, 2, fingerprint={**FINGERPRINT, "processor": "AVX2"})
    found = second.find()
    assert_serves(found, 2 * CYCLE)
    assert found.note == "not bit-comparable: processor was AVX512, now AVX2"
    learner = FakeLearner([SPEC])
    assert found.saved is not None
    learner.restore({3: found.saved})
    train(second, learner, 1)
    third = checkpoints_of(place, 3, fingerprint={**FINGERPRINT, "processor": "AVX2"}).find()
    assert third.mixed_with == ["processor was AVX512, now AVX2"]


def test_one_that_was_given_up_disturbs_none_of_its_successor(place: Place) -> None:
    first = checkpoints_of(place)
    orphan = train(first, FakeLearner([SPEC]), 2)
    second = checkpoints_of(place, 2)
    learner = FakeLearner([SPEC])
    saved = second.find().saved
    assert saved is not None
    learner.restore({3: saved})
    train(second, learner, 1)
    train(first, orphan, 3)
    assert_serves(checkpoints_of(place, 3).find(), 6 * CYCLE)
    assert "2-600.checkpoint" in names(place)


@pytest.mark.parametrize("full", ["append", "write"])
def test_a_full_disk_costs_the_new_checkpoint_alone(
    place: Place, monkeypatch: pytest.MonkeyPatch, full: str
) -> None:
    """Whichever of its two files does not fit."""
    checkpoints = checkpoints_of(place)
    learner = train(checkpoints, FakeLearner([SPEC]), 2)
    before = names(place)

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patched:
        patched.setattr({"append": Journal, "write": sealed_file}[full], full, fail)
        with pytest.raises(OSError, match="No space left"):
            train(checkpoints, learner, 1)
    assert names(place) == before
    assert_serves(checkpoints_of(place, 2).find(), 4 * CYCLE)
    train(checkpoints, learner, 1)
    assert_serves(checkpoints_of(place, 2).find(), 8 * CYCLE)


def test_what_was_learned_outlives_the_checkpoints(
    place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    theta, unit = np.arange(5, dtype=np.float32), np.ones(3, np.float32)
    inside = Inside((8, 8), "tanh")
    learned = Snapshot(
        200, 1, inside, deterministic(theta, unit, unit, 1), Critic(theta, -3.5, 2.5)
    )
    monkeypatch.setattr(FakeLearner, "snapshot", lambda self, seed: learned)
    checkpoints = checkpoints_of(place)
    assert find_snapshot(place, "run-3") is None
    checkpoints.save_policy(train(checkpoints, FakeLearner([SPEC]), 2))
    remove_checkpoints(place, "run-3")
    assert names(place) == {"policy"}
    remove_checkpoints(place, "run-3")
    remove_checkpoints(place, "run-4")
    found = find_snapshot(place, "run-3")
    assert found is not None
    assert (found.timestep, found.inside, found.actions) == (200, inside, 1)
    np.testing.assert_array_equal(found.policy.theta, theta, strict=True)
    assert found.critic is not None
    assert (found.critic.value_mean, found.critic.value_std) == (-3.5, 2.5)


def test_on_the_mass_point_what_was_learned_by_the_epochs_of_figure_2_is_kept(
    place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    theta, unit = np.arange(5, dtype=np.float32), np.ones(3, np.float32)
    inside = Inside((8, 8), "tanh")

    def learned(self: FakeLearner, seed: int) -> Snapshot:
        return Snapshot(self.timestep, 1, inside, deterministic(theta, unit, unit, 1))

    monkeypatch.setattr(FakeLearner, "snapshot", learned)
    for spec, kept in ((replace(SPEC, environment="MassPoint"), [1, 10]), (SPEC, [])):
        root = f"{place}/{spec.environment}"
        checkpoints, learner = checkpoints_of(root, spec=spec), FakeLearner([spec])
        while not learner.finished:
            learner.advance()
            checkpoints.save_epoch(learner)
        found = find_epochs(root, "run-3")
        assert {epoch: each.timestep for epoch, each in found.items()} == {
            epoch: 800 * epoch for epoch in kept
        }


def test_where_the_place_does_not_answer_it_is_asked_again_with_patience(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 2)
    silences, names = [2], DiskFolder.names

    def answer_late(folder: DiskFolder) -> list[str]:
        if silences[0] == 0:
            return names(folder)
        silences[0] -= 1
        raise UnreachableError(errno.EHOSTUNREACH, "the store does not answer")

    monkeypatch.setattr(DiskFolder, "names", answer_late)
    assert_serves(checkpoints_of(tmp_path, 2).find(lambda: True), 4 * CYCLE)
    silences[0] = 2
    assert checkpoints_of(tmp_path, 2).find() == Found(
        note="checkpoints could not be listed (the store does not answer), begun again from step 0"
    )


def test_where_the_place_cannot_be_had_nothing_is_asked_again(bucket: str) -> None:
    place = bucket.replace("d3pg", "no-such-bucket")
    note = checkpoints_of(place).find(pytest.fail).note
    assert note.startswith(f"checkpoints could not be listed (the store has no bucket of {place}")
    with pytest.raises(UnavailableError, match="no bucket"):
        train(checkpoints_of(place), FakeLearner([SPEC]), 1)


def test_checkpoints_of_the_version_before_still_serve(tmp_path: Path) -> None:
    """Their bytes on a disk: a journal is one file that pieces were appended to."""
    train(checkpoints_of(tmp_path), FakeLearner([SPEC]), 2)
    content = (tmp_path / "run-3" / "1.journal").read_bytes()
    read = []
    while content:
        length = int.from_bytes(content[:8], "little")
        read.append(sealed_file.unpacked(content[8 : 8 + length]))
        content = content[8 + length :]
    lived = np.concatenate([each["lived"] for each in read])
    np.testing.assert_array_equal(lived, 3 * 10**6 + np.arange(4 * CYCLE))
    digest, _, sealed = (tmp_path / "run-3" / "1-400.checkpoint").read_bytes().partition(b"\n")
    assert digest == hashlib.sha256(sealed).hexdigest().encode()
    assert json.loads(sealed.partition(b"\n")[0])["format"] == 2
