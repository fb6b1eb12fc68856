"""`python -m service`: the server, until Ctrl-C or SIGTERM."""

import argparse
import json
import logging
import signal
import socket
import sys
from contextlib import closing, suppress

import uvicorn
from fastapi import FastAPI
from pydantic import ValidationError

from service.api.access.links import signin_path
from service.api.access.register import Register
from service.api.logs import configure_logging
from service.bootstrap import wired
from service.listening import listen, refuse_unusable
from service.refusal import RefusalError
from service.settings import Settings

SHUTDOWN_SECONDS = 2
"""How long open requests may take to end; then they are cut."""

OVERHEARD = (
    "D3PG_HOST=%s without TLS: anybody on that network can read tokens and sessions; set "
    "D3PG_TLS_CERTIFICATE and D3PG_TLS_KEY, or D3PG_PUBLIC_URL to the https:// address of a proxy."
)

log = logging.getLogger(__name__)


def main() -> int:
    """Run the server. A refusal to start is a sentence on standard error and exit code 2."""
    parser = argparse.ArgumentParser(prog="python -m service")
    parser.add_argument("--json", action="store_true", help="say as JSON where it is found")
    as_json = parser.parse_args().json
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
    if settings.is_overheard:
        log.warning(OVERHEARD, settings.host)
    try:
        refuse_unusable(settings.tls_certificate, settings.tls_key)
        with closing(listen(settings.host, settings.port)) as listener, wired(settings) as app:
            here = settings.model_copy(update={"port": listener.getsockname()[1]})
            register: Register = app.state.register
            url, path = here.public.url, signin_path(register.new_code())
            found = {"url": url, "link": f"{url}{path}", "data_dir": str(here.data_dir)}
            print(json.dumps(found) if as_json else found["link"], flush=True)  # noqa: T201
            serve(app, listener, here)
    except RefusalError as refusal:
        print(refusal, file=sys.stderr)  # noqa: T201
        return 2
    except KeyboardInterrupt:  # before it served, or once more while it was closing
        return 130
    return 0


def serve(app: FastAPI, listener: socket.socket, settings: Settings) -> None:
    """Answer requests until the process is told to end."""
    config = uvicorn.Config(
        app,
        log_config=None,
        timeout_graceful_shutdown=SHUTDOWN_SECONDS,
        ssl_certfile=settings.tls_certificate,
        ssl_keyfile=settings.tls_key,
        proxy_headers=False,  # whom it serves, and where, the settings say
    )
    with suppress(KeyboardInterrupt):  # it ends in order, then hands on the signal that ended it
        uvicorn.Server(config).run(sockets=[listener])


if __name__ == "__main__":
    sys.exit(main())
