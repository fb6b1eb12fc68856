"""The socket that the service listens on, taken before anything else is started."""

import errno
import socket

from service.refusal import RefusalError

BACKLOG = 2048
REASONS = {
    errno.EADDRINUSE: "something else listens there: end it, or choose another port with "
    "D3PG_PORT (--port). `d3pg doctor` says whether it is a service of ours",
    errno.EACCES: "this user may not: choose a port from 1024 on with D3PG_PORT (--port)",
    errno.EADDRNOTAVAIL: "this machine has no such address: correct D3PG_HOST (--host)",
}


class AddressError(RefusalError):
    """The service cannot listen there; the text says why."""


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens; port 0 takes a free one. Raises AddressError."""
    try:
        family, *_, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        return socket.create_server(address[:2], family=family, backlog=BACKLOG)
    except OSError as error:
        reason = REASONS.get(error.errno or 0, error.strerror)
        raise AddressError(f"cannot listen on port {port} of {host}: {reason}") from error
