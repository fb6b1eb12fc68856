"""The socket that the service listens on, taken before anything else is started; its TLS."""

import errno
import socket
import ssl
from pathlib import Path

from service.refusal import RefusalError

BACKLOG = 2048
REASONS = {
    errno.EADDRINUSE: "something else listens there: end it, or choose another port with "
    "D3PG_PORT (--port). `d3pg doctor` says whether it is a service of ours",
    errno.EACCES: "this user may not: choose a port of at least 1024 with D3PG_PORT (--port)",
    errno.EADDRNOTAVAIL: "this machine has no such address: correct D3PG_HOST (--host)",
}


class AddressError(RefusalError):
    """The service cannot listen there; the text says why."""


class CertificateError(RefusalError):
    """The service cannot use TLS with these files; the text says why."""


def refuse_unusable(certificate: Path | None, key: Path | None) -> None:
    """Raise CertificateError for files with which the service could not use TLS."""
    if certificate is None or key is None:
        return
    try:
        ssl.create_default_context(ssl.Purpose.CLIENT_AUTH).load_cert_chain(
            certificate, key, password=_no_password
        )
    except OSError as error:
        raise CertificateError(
            f"cannot speak TLS with D3PG_TLS_CERTIFICATE={certificate} and D3PG_TLS_KEY={key} "
            f"({error.strerror or error}): name a certificate chain and its key, both PEM, the key "
            "without a password, readable by this user"
        ) from error


def _no_password() -> str:
    """Answer OpenSSL's question for a password, instead of a person at a terminal."""
    return ""


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens; port 0 takes a free one. Raises AddressError.

    Its connections send at once (TCP_NODELAY, which Linux hands on to them; asyncio sets it only on
    sockets that name their protocol). Else the body of an answer waits some 40 ms for the client to
    acknowledge the head.
    """
    try:
        family, *_, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        listener = socket.create_server(address[:2], family=family, backlog=BACKLOG)
    except OSError as error:
        reason = REASONS.get(error.errno or 0, error.strerror)
        raise AddressError(f"cannot listen on port {port} of {host}: {reason}") from error
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return listener
