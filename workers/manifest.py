"""The manifest of a checkpoint: what it is of, and which files it is made of."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from algorithms.measurement import Measurement
from workers.run_spec import RunSpec
from workers.sealed_file import DamagedError

FORMAT = 1


@dataclass(frozen=True)
class Part:
    """A sealed file, and the digest it must have."""

    file: str
    digest: str


@dataclass(frozen=True)
class Manifest:
    """One checkpoint of a run.

    spec         digest of the run's spec
    timestep     environment steps the run had taken
    fingerprint  of the worker that wrote it
    mixed_with   how the workers of earlier attempts differed from it; empty while none did
    state        the learner's state of the run
    journal      the learner's journal of the run, piece after piece
    measurements all of the run, for those that were never delivered
    """

    spec: str
    timestep: int
    fingerprint: Mapping[str, Any]
    mixed_with: Sequence[str]
    state: Part
    journal: Sequence[Part]
    measurements: Sequence[Measurement]

    @property
    def files(self) -> set[str]:
        """The names of its parts."""
        return {part.file for part in (self.state, *self.journal)}

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
            fields["state"] = Part(**fields["state"])
            fields["journal"] = [Part(**part) for part in fields["journal"]]
            fields["measurements"] = [Measurement(**each) for each in fields["measurements"]]
            return cls(**fields)
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise DamagedError(f"its manifest cannot be read: {error}") from error


def spec_digest(spec: RunSpec) -> str:
    """The SHA-256 of a spec."""
    text = json.dumps(spec.to_json(), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()
