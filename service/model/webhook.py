"""Webhooks: which URL is called at the end of a sweep, what is sent, and how it is signed.

    D3PG-Signature: t=1764489600,v1=HMAC-SHA256(secret, "1764489600." + body), in hex

A receiver computes the same and refuses an old t: then nobody else can have sent it.
"""

import hashlib
import hmac
import ipaddress
import json
import socket
from collections.abc import Collection
from dataclasses import asdict, dataclass
from urllib.parse import urlsplit

from service.model.sweep import Sweep

MAX_URL = 2000
SIGNATURE = "D3PG-Signature"
DELIVERY = "D3PG-Delivery"


@dataclass(frozen=True)
class Due:
    """An end of a sweep to deliver."""

    sweep: Sweep
    url: str
    tries: int
    ended_at: float

    @property
    def name(self) -> str:
        """The name of this end of this sweep: every try to deliver it carries the name."""
        return f"{self.sweep.id}-{self.ended_at:.3f}"

    def body(self, service_url: str) -> bytes:
        """What is sent."""
        sweep = self.sweep
        document = {
            "event": "sweep.ended",
            "sweep": {
                "id": sweep.id,
                "name": sweep.name,
                "status": sweep.status.value,
                "runs": {"total": sweep.runs.total, **asdict(sweep.runs)},
                "page": f"{service_url}/sweeps/{sweep.id}",
            },
            "ended_at": self.ended_at,
        }
        return json.dumps(document).encode()


def signature(secret: str, body: bytes, at: int) -> str:
    """Return the value of the signature's header."""
    signed = hmac.digest(secret.encode(), f"{at}.".encode() + body, hashlib.sha256)
    return f"t={at},v1={signed.hex()}"


def webhook_url(text: str) -> str:
    """Return a URL that can be a webhook. Raises ValueError for anything else."""
    parts = urlsplit(text)
    if parts.scheme not in {"http", "https"} or not parts.hostname or not text.isprintable():
        raise ValueError("is not a URL: write http://HOST/PATH or https://HOST/PATH")
    if parts.username or parts.password:
        raise ValueError("holds a user or a password: put a secret into its path or query")
    if parts.port == 0:  # of what is no port, urllib raises ValueError too
        raise ValueError("has the port 0, which nobody listens on")
    return text


def refusal(url: str, hosts: Collection[str]) -> str:
    """Return why a URL's host may not be called; empty if it may. Without hosts, any may be."""
    host = urlsplit(url).hostname or ""
    if hosts and host not in hosts:
        return f"its host {host!r} is not one of those in D3PG_WEBHOOK_HOSTS"
    if not hosts and _is_link_local(host):
        return f"{host!r} is a link-local address, where clouds keep secrets"
    return ""


def resolved_refusal(url: str, hosts: Collection[str]) -> str:
    """Apply `refusal` to the addresses that the host has now. Raises OSError if it has none."""
    if said := refusal(url, hosts):
        return said
    parts = urlsplit(url)
    found = socket.getaddrinfo(parts.hostname, parts.port or 443, type=socket.SOCK_STREAM)
    is_local = any(_is_link_local(str(address[4][0])) for address in found)
    return "it leads to a link-local address" if is_local and not hosts else ""


def _is_link_local(host: str) -> bool:
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return False
    mapped = getattr(address, "ipv4_mapped", None)
    return (mapped or address).is_link_local
