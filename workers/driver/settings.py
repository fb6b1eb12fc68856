"""Settings of the process that drives Ray: each is an argument of its start."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Self

BINDS_ITSELF = -1


@dataclass(frozen=True)
class DriverSettings:
    """Where the process listens and writes; a service tells it what to do (`Terms`).

    socket    Unix socket that services connect to
    logs      folder of the workers' logs
    spool     file for reports that no service has received
    scratch   folder for Ray's own files, removed at the end; names the process
    listener  descriptor that listens there already; -1: the process is separate, binds the socket
              and waits for services without a limit
    """

    socket: Path
    logs: Path
    spool: Path
    scratch: str
    listener: int = BINDS_ITSELF

    @property
    def stands_alone(self) -> bool:
        """Whether no service has started the process."""
        return self.listener == BINDS_ITSELF

    def arguments(self) -> list[str]:
        """Write the settings as arguments; `from_arguments` reads them."""
        return [f"--{name}={value}" for name, value in asdict(self).items()]

    @classmethod
    def from_arguments(cls, arguments: Sequence[str] | None = None) -> Self:
        """Read what `arguments` wrote; by default the arguments of this process."""
        parser = argparse.ArgumentParser(prog="python -m workers")
        for field in fields(cls):
            kind = field.type if isinstance(field.type, type) else str
            is_optional = field.name == "listener"
            parser.add_argument(
                f"--{field.name}",
                type=kind,
                required=not is_optional,
                default=BINDS_ITSELF if is_optional else None,
            )
        return cls(**vars(parser.parse_args(arguments)))
