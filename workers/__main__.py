"""`python -m workers`: the process that drives Ray for a PoolProcess."""

import argparse
import shutil
import socket
from pathlib import Path

from workers.driver.cluster import drive
from workers.driver.placement import Bounds


def main() -> None:
    """Read where the channel is, then drive Ray until a service closes the pool."""
    parser = argparse.ArgumentParser(prog="python -m workers")
    parser.add_argument("--listener", type=int, required=True, help="descriptor of the socket")
    parser.add_argument("--spool", type=Path, required=True, help="file for undelivered reports")
    parser.add_argument("--least", type=int, required=True, help="workers that are always kept")
    parser.add_argument("--most", type=int, required=True, help="workers at most")
    parser.add_argument("--worker-bytes", type=int, required=True, help="memory of each; 0: any")
    parser.add_argument("--address", required=True, help="cluster to join; empty: a local one")
    parser.add_argument("--logs", type=Path, required=True, help="folder of the workers' logs")
    parser.add_argument("--checkpoints", required=True, help="folder or s3://bucket/prefix")
    parser.add_argument("--scratch", required=True, help="folder for Ray's own files")
    options = parser.parse_args()
    listener = socket.socket(fileno=options.listener)
    try:
        drive(
            listener,
            Bounds(options.least, options.most),
            options.address,
            worker_bytes=options.worker_bytes,
            logs=options.logs,
            checkpoints=options.checkpoints,
            spool=options.spool,
            scratch=options.scratch,
        )
    finally:  # also done by who made it, unless killed
        shutil.rmtree(options.scratch, ignore_errors=True)


if __name__ == "__main__":
    main()
