"""`python -m workers`: the process that drives Ray for a PoolProcess."""

import argparse
import shutil
import socket
from pathlib import Path

from workers.actor import drive


def main() -> None:
    """Read where the channel is, then drive Ray until the channel ends."""
    parser = argparse.ArgumentParser(prog="python -m workers")
    parser.add_argument("--channel", type=int, required=True, help="descriptor of the socket")
    parser.add_argument("--workers", type=int, required=True, help="local worker slots")
    parser.add_argument("--address", required=True, help="cluster to join; empty: a local one")
    parser.add_argument("--logs", type=Path, required=True, help="folder of the workers' logs")
    parser.add_argument("--checkpoints", type=Path, required=True, help="folder of checkpoints")
    parser.add_argument("--scratch", required=True, help="folder for Ray's own files")
    options = parser.parse_args()
    channel = socket.socket(fileno=options.channel)
    try:
        drive(
            channel,
            options.workers,
            options.address,
            logs=options.logs,
            checkpoints=options.checkpoints,
            scratch=options.scratch,
        )
    finally:  # also done by who made it, unless killed
        shutil.rmtree(options.scratch, ignore_errors=True)


if __name__ == "__main__":
    main()
