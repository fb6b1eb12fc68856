"""Checkpoints of a run: where a worker leaves it, so that another resumes it with the same bits.

    <place>/<run id>/2-4800.checkpoint  attempt 2 at timestep 4800: its manifest, a line feed,
                                        the state that the next bits depend on
                     2.journal          the experience of attempt 2 (workers.checkpoints.journal)
                     policy             what was learned (algorithms.snapshot)
                     policy-epoch-10    and as of an epoch that figure 2 shows

All but the journal are sealed files; the place is a disk or a bucket (checkpoints/folder.py). A
checkpoint is written after its journal and says how much of which journals belongs to it, with the
digests, so what can be read is whole. The last two are kept; where the newest is damaged, the one
before serves. A worker that was given up may go on writing for a while: it writes under its own
attempt's number and removes nothing of later ones.

A checkpoint serves if it has the same spec and was made by the same code. A checkpoint of another
machine or other libraries serves, too, but the run then has bits of two kinds and is marked so. A
checkpoint of other code does not serve: this code may read it differently.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from algorithms.learner import Learner
from algorithms.measurement import MEASURE_EVERY, Measurement
from algorithms.snapshot import Snapshot, snapshot_of
from algorithms.state import Saved, State
from workers.checkpoints import sealed_file
from workers.checkpoints.checkpoint_folder import (
    EPOCHS,
    NAME,
    POLICY,
    SURFACE_TASK,
    epoch_file,
    newest_first,
)
from workers.checkpoints.folder import Folder
from workers.checkpoints.journal import Beginning, Journal, pieces
from workers.checkpoints.manifest import Manifest, can_go_on, spec_digest
from workers.checkpoints.patience import Patience, answered, without_patience
from workers.checkpoints.place import Place, folder_in
from workers.checkpoints.sealed_file import DamagedError
from workers.messages.assignment import Assignment

ANEW = "begun again from step 0"


@dataclass(frozen=True)
class Found:
    """Where a run is resumed.

    timestep      0 if it starts again
    saved         None in that case
    measurements  all up to there
    mixed_with    how the machines that trained it so far differ from this one
    note          a remark, a sentence; mostly empty
    """

    timestep: int = 0
    saved: Saved | None = None
    measurements: Sequence[Measurement] = ()
    mixed_with: Sequence[str] = ()
    note: str = ""


class Checkpoints:
    """Those of one run, as its worker reads and writes them."""

    def __init__(
        self, place: Place, assignment: Assignment, fingerprint: Mapping[str, Any]
    ) -> None:
        """Read and write nothing yet. Raises ValueError for an invalid name."""
        self._folder = folder_in(place, assignment.run_id)
        self._attempt = assignment.attempt
        self._journal = Journal(self._folder, f"{assignment.attempt}.journal")
        self._journal_end = 0  # the timestep that it has come to
        self._earlier: Sequence[Beginning] = ()  # journals of earlier attempts
        self._seed = assignment.spec.seed
        self._task = assignment.spec.environment
        self._spec = spec_digest(assignment.spec)
        self._can_go_on = can_go_on(assignment.spec)
        self._fingerprint = fingerprint
        self._mixed_with: Sequence[str] = ()
        self._kept: list[str] = []  # the files of the last two, the newer one last

    def find(self, patience: Patience = without_patience) -> Found:
        """Find the newest checkpoint that serves."""
        try:
            return answered(self._find, patience)
        except OSError as trouble:
            note = f"checkpoints could not be listed ({trouble.strerror}), {ANEW}"
            return Found(note=note)

    def _find(self) -> Found:
        problems: list[str] = []
        for name in newest_first(self._folder):
            try:
                text, _, state = sealed_file.read(self._folder, name).partition(b"\n")
                manifest = Manifest.from_text(text)
                if refusal := self._refusal(manifest):
                    problems.append(refusal)
                else:
                    saved = Saved(sealed_file.unpacked(state), self._lived_through(manifest))
                    return self._take_up(manifest, name, saved, problems)
            except DamagedError as damage:
                which = "the one before" if problems else "newest checkpoint"
                problems.append(f"{which} damaged ({damage})")
        said = list(dict.fromkeys(problems))
        return Found(note=", ".join([*said, ANEW]) if said else "")

    def save(self, learner: Learner, measurements: Sequence[Measurement]) -> None:
        """Write a checkpoint. Raises OSError; the one before stands then."""
        timestep = learner.timestep
        name = f"{self._attempt}-{timestep}.checkpoint"
        try:
            rows = learner.journal(self._seed, self._journal_end)
            if rows:
                self._journal.append(rows)
                self._journal_end = timestep
            manifest = Manifest(
                spec=self._spec,
                timestep=timestep,
                fingerprint=self._fingerprint,
                mixed_with=self._mixed_with,
                journal=[*self._earlier, *self._journal.so_far()],
                measurements=list(measurements),
            )
            state = sealed_file.packed(learner.state(self._seed))
            sealed_file.write(self._folder, name, manifest.to_text() + b"\n" + state)
            self._kept = [*self._kept[-1:], name]
        finally:
            self._remove_what_is_not_kept()

    def save_end(self, learner: Learner, measurements: Sequence[Measurement]) -> bool:
        """Write a last checkpoint, if a longer run could be resumed there; return whether.

        This is not possible off the grid of measurements, where only the end of the run was
        measured. Raises OSError.
        """
        is_start = self._can_go_on and learner.timestep % MEASURE_EVERY == 0
        if is_start:
            self.save(learner, measurements)
        return is_start

    def save_policy(self, learner: Learner) -> None:
        """Write what has been learned, if there is anything. Raises OSError."""
        self._save_snapshot(POLICY, learner)

    def save_epoch(self, learner: Learner) -> None:
        """Keep the critic at the end of an epoch that figure 2 shows. Raises OSError."""
        epoch, steps_left = divmod(learner.timestep, MEASURE_EVERY)
        if self._task == SURFACE_TASK and epoch in EPOCHS and not steps_left:
            self._save_snapshot(epoch_file(epoch), learner)

    def _save_snapshot(self, name: str, learner: Learner) -> None:
        snapshot = learner.snapshot(self._seed)
        if snapshot is not None:
            sealed_file.write(self._folder, name, sealed_file.packed(snapshot.arrays()))

    def _take_up(
        self, manifest: Manifest, name: str, saved: Saved, problems: Sequence[str]
    ) -> Found:
        differing = _differences(self._fingerprint, manifest.fingerprint)
        self._mixed_with = [*manifest.mixed_with, *differing]
        self._kept = [name]
        self._earlier, self._journal_end = manifest.journal, manifest.timestep
        said = [*problems, f"resumed from step {manifest.timestep}"] if problems else []
        if self._mixed_with:
            said.append(f"not bit-comparable: {'; '.join(self._mixed_with)}")
        return Found(
            manifest.timestep, saved, manifest.measurements, self._mixed_with, ", ".join(said)
        )

    def _refusal(self, manifest: Manifest) -> str:
        if manifest.spec != self._spec:
            return "its checkpoint is of another spec"
        if manifest.fingerprint.get("code") != self._fingerprint["code"]:
            return "its checkpoint was made by other code"
        return ""

    def _lived_through(self, manifest: Manifest) -> State:
        return _joined([p for each in manifest.journal for p in pieces(self._folder, each)])

    def _remove_what_is_not_kept(self) -> None:
        """Remove files that the last two checkpoints do not need, but none of later attempts."""
        journals = [*self._earlier, *self._journal.so_far()]
        needed = {*self._kept, *(each.file for each in journals)}

        def is_unneeded(name: str) -> bool:
            named = NAME.match(name)
            return bool(named and name not in needed and int(named["attempt"]) <= self._attempt)

        self._folder.remove(is_unneeded)


def find_snapshot(place: Place, run_id: str) -> Snapshot | None:
    """What a run has learned, as of its last checkpoint or its end; None if there is nothing.

    Raises ValueError for a name that is none, DamagedError, OSError.
    """
    folder = folder_in(place, run_id)
    return _snapshot(folder, POLICY) if POLICY in folder.names() else None


def find_epochs(place: Place, run_id: str) -> dict[int, Snapshot]:
    """What a run had learned by the epochs that figure 2 shows, as far as it has reached them.

    Raises ValueError for a name that is none, DamagedError, OSError.
    """
    folder = folder_in(place, run_id)
    written = folder.names()
    return {
        epoch: _snapshot(folder, epoch_file(epoch))
        for epoch in EPOCHS
        if epoch_file(epoch) in written
    }


def _snapshot(folder: Folder, name: str) -> Snapshot:
    return snapshot_of(sealed_file.unpacked(sealed_file.read(folder, name)))


def _joined(states: Sequence[State]) -> State:
    """Pieces of a journal as one."""
    names = states[0] if states else {}
    return {name: np.concatenate([each[name] for each in states]) for name in names}


def _differences(own: Mapping[str, Any], other: Mapping[str, Any]) -> list[str]:
    """What differs between this machine and another, in words."""
    return [
        f"{name} was {other.get(name)}, now {own.get(name)}"
        for name in sorted({*own, *other})
        if own.get(name) != other.get(name)
    ]
