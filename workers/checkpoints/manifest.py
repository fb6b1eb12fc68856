"""The manifest of a checkpoint: its run, and which journals belong to it."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from algorithms import catalogue
from algorithms.measurement import Measurement
from workers.checkpoints.journal import Beginning
from workers.checkpoints.sealed_file import DamagedError
from workers.messages.run_spec import RunSpec

FORMAT = 2


def can_go_on(spec: RunSpec) -> bool:
    """Whether the run has the bits of a shorter one up to that one's end."""
    algorithm = catalogue.known(spec.algorithm)
    return algorithm is not None and algorithm.can_go_on


@dataclass(frozen=True)
class Manifest:
    """One checkpoint of a run.

    spec         digest of what the run's bits up to there depend on
    timestep     environment steps the run had taken
    fingerprint  of the worker that wrote it
    mixed_with   how the workers of earlier attempts differed from it; empty while none did
    journal      the learner's journal of the run, attempt after attempt
    measurements all of the run, for those that were never delivered
    """

    spec: str
    timestep: int
    fingerprint: Mapping[str, Any]
    mixed_with: Sequence[str]
    journal: Sequence[Beginning]
    measurements: Sequence[Measurement]

    def to_text(self) -> bytes:
        """Write it as JSON; `from_text` gives an equal one back (a NaN stays a NaN)."""
        return json.dumps({"format": FORMAT, **asdict(self)}).encode()

    @classmethod
    def from_text(cls, text: bytes) -> "Manifest":
        """Read what `to_text` wrote. Raises DamagedError for anything else."""
        try:
            fields = json.loads(text)
            if (found := fields.pop("format")) != FORMAT:
                raise DamagedError(f"its format is {found}, not {FORMAT}")
            fields["journal"] = [Beginning(**each) for each in fields["journal"]]
            fields["measurements"] = [Measurement(**each) for each in fields["measurements"]]
            return cls(**fields)
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            raise DamagedError(f"its manifest cannot be read: {error}") from error


def spec_digest(spec: RunSpec) -> str:
    """The SHA-256 of a spec; without its timesteps if the run can go on."""
    fields = spec.to_json()
    if can_go_on(spec):
        del fields["timesteps"]
    text = json.dumps(fields, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()
