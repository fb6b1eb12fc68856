"""Terms of a service for the process that drives Ray: the first message that it sends."""

import json
from dataclasses import asdict, dataclass
from typing import Self

from workers.driver.placement import Bounds
from workers.messages.report import FORMAT


class UnusableTermsError(ValueError):
    """The first message does not have the form of terms; the text says why."""


@dataclass(frozen=True)
class Terms:
    """Where the workers are and what they may take.

    address      cluster to join; empty: a local one, made and ended with the process
    least, most  workers that are kept, at least and at most
    worker_bytes memory that each needs of its node; 0: any
    checkpoints  folder, as the workers see it, or s3://bucket/prefix
    """

    address: str
    least: int
    most: int
    worker_bytes: int
    checkpoints: str

    @property
    def bounds(self) -> Bounds:
        """How many workers there may be."""
        return Bounds(self.least, self.most)

    def to_line(self) -> bytes:
        """Write the terms, with the format that the service speaks; `from_line` reads them."""
        return json.dumps({"format": FORMAT, "terms": asdict(self)}).encode() + b"\n"

    @classmethod
    def from_line(cls, line: bytes) -> Self:
        """Read what `to_line` wrote. Raises UnusableTermsError."""
        try:
            document = json.loads(line)
            spoken = document["format"]
            if spoken == FORMAT:
                return cls(**document["terms"])
        except (LookupError, TypeError, ValueError, RecursionError):
            raise UnusableTermsError("it did not say what it asks for") from None
        raise UnusableTermsError(
            f"it speaks format {spoken} and this process format {FORMAT}: "
            "start both from the same version"
        )
