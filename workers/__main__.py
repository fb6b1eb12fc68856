"""`python -m workers`: the process that drives Ray for a service."""

import shutil

from workers.driver.cluster import drive
from workers.driver.reception import listening
from workers.driver.settings import DriverSettings


def main() -> None:
    """Drive Ray until a service closes the pool, or no service connects."""
    settings = DriverSettings.from_arguments()
    try:
        with listening(settings) as listener:
            drive(listener, settings)
    finally:  # also done by who made it, unless killed
        shutil.rmtree(settings.scratch, ignore_errors=True)


if __name__ == "__main__":
    main()
