"""`python -m workers`: the process that drives Ray for a PoolProcess."""

import shutil
import socket

from workers.driver.cluster import drive
from workers.driver.settings import DriverSettings


def main() -> None:
    """Drive Ray until a service closes the pool, or none comes."""
    settings = DriverSettings.from_arguments()
    try:
        drive(socket.socket(fileno=settings.listener), settings)
    finally:  # also done by who made it, unless killed
        shutil.rmtree(settings.scratch, ignore_errors=True)


if __name__ == "__main__":
    main()
