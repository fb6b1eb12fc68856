"""Where a service is found, with which token, and which certificates to trust over TLS."""

from __future__ import annotations

import os
import ssl
from pathlib import Path

from service.address import url_of
from service.client.errors import ServiceError


def find_token() -> str:
    """The token to call a service with.

    That is `D3PG_TOKEN`, else the content of the file `D3PG_TOKEN_FILE`, else of the file `token`
    in `D3PG_DATA_DIR` (./d3pg-data).

    Raises:
        ServiceError: if none is there, or the file can be read by other users.
    """
    if token := os.environ.get("D3PG_TOKEN"):
        return token
    named = os.environ.get("D3PG_TOKEN_FILE")
    file = Path(named or Path(os.environ.get("D3PG_DATA_DIR") or "d3pg-data") / "token")
    try:
        if file.stat().st_mode & 0o077:
            raise ServiceError(
                f"{file} can be read by other users, so its token is no secret: run chmod 600 "
                f"{file}, or make another token if you do not trust them."
            )
        return file.read_text(encoding="utf-8").strip()
    except OSError as error:
        raise ServiceError(
            f"No token: D3PG_TOKEN is not set and {file} cannot be read ({error.strerror}). "
            "Start the service here with `d3pg serve`, name its data directory with "
            "D3PG_DATA_DIR, or a file with a token of yours with D3PG_TOKEN_FILE."
        ) from error


def own_url() -> str:
    """Where a service with this environment's settings is found."""
    has_tls = bool(os.environ.get("D3PG_TLS_CERTIFICATE"))
    if has_tls and (public := os.environ.get("D3PG_PUBLIC_URL")):
        return public  # it has the name that the certificate is for
    port = os.environ.get("D3PG_PORT") or "8000"
    host = os.environ.get("D3PG_HOST") or "127.0.0.1"
    return url_of(host, port, "https" if has_tls else "http")


def trusted() -> ssl.SSLContext | bool:
    """Certificates to trust over TLS: the usual authorities, and a service with our settings."""
    certificate = os.environ.get("D3PG_TLS_CERTIFICATE")
    if not certificate:
        return True
    context = ssl.create_default_context()
    context.load_verify_locations(certificate)
    return context
