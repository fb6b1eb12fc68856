"""What the process that drives Ray is told as it is started: each setting is an argument."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Self

from workers.driver.placement import Bounds


@dataclass(frozen=True)
class DriverSettings:
    """Where the workers are and what they may take.

    listener      descriptor of the socket that services connect to
    address       cluster to join; empty: a local one, made and ended with the process
    least, most   workers that are always kept, and at most
    worker_bytes  memory that each needs of its node; 0: any
    logs          folder of the workers' logs
    checkpoints   folder or s3://bucket/prefix
    spool         file for reports that nobody has taken
    scratch       folder for Ray's own files, removed at the end; names the process
    """

    listener: int
    address: str
    least: int
    most: int
    worker_bytes: int
    logs: Path
    checkpoints: str
    spool: Path
    scratch: str

    @property
    def bounds(self) -> Bounds:
        """How many workers there may be."""
        return Bounds(self.least, self.most)

    def arguments(self) -> list[str]:
        """Write the settings as arguments; `from_arguments` reads them."""
        return [f"{_flag(name)}={value}" for name, value in asdict(self).items()]

    @classmethod
    def from_arguments(cls, arguments: Sequence[str] | None = None) -> Self:
        """Read what `arguments` wrote; by default the arguments of this process."""
        parser = argparse.ArgumentParser(prog="python -m workers")
        for field in fields(cls):
            kind = field.type if isinstance(field.type, type) else str
            parser.add_argument(_flag(field.name), type=kind, required=True)
        return cls(**vars(parser.parse_args(arguments)))


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"
