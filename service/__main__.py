"""`python -m service`: the server, until Ctrl-C or SIGTERM."""

import signal
import sys

import uvicorn
from pydantic import ValidationError
from sqlalchemy.exc import OperationalError

from service.api.access_token import access_token, signin_link
from service.api.logs import configure_logging
from service.bootstrap import wired
from service.data_dir import DataDirInUseError
from service.settings import Settings
from service.store.refusal import DatabaseInUseError, MissingDriverError, UnsafeSQLiteError

SHUTDOWN_SECONDS = 2
"""How long open requests may take to end; then they are cut."""


def main() -> int:
    """Serve. A refusal to start is a sentence on standard error and exit code 2."""
    try:
        settings = Settings()
    except ValidationError as error:
        for problem in error.errors():
            name = "_".join(["D3PG", *(str(part).upper() for part in problem["loc"])])
            print(f"{name}: {problem['msg']}", file=sys.stderr)  # noqa: T201
        return 2
    configure_logging()
    # As Ctrl-C: uvicorn closes its connections, then everything else is closed on the way out.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with wired(settings) as app:
            print(signin_link(settings, access_token(settings)), flush=True)  # noqa: T201
            uvicorn.run(
                app,
                host=settings.host,
                port=settings.port,
                log_config=None,
                timeout_graceful_shutdown=SHUTDOWN_SECONDS,
            )
    except (
        DataDirInUseError,
        DatabaseInUseError,
        MissingDriverError,
        UnsafeSQLiteError,
    ) as refusal:
        print(refusal, file=sys.stderr)  # noqa: T201
        return 2
    except OperationalError as error:
        print(f"The database cannot be opened: {error.orig}", file=sys.stderr)  # noqa: T201
        return 2
    except KeyboardInterrupt:  # before it served, or once more while it was closing
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
