"""Addresses: hosts as URLs write them, and where a service that listens on one is found."""

from contextlib import suppress
from ipaddress import ip_address
from urllib.parse import urlsplit

LOOPBACK_HOSTS = frozenset({"127.0.0.1", "localhost", "[::1]"})
WILDCARDS = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}  # noqa: S104 - recognised, not bound
"""Addresses that mean every interface, and where this machine reaches such a service."""


def as_url_host(host: str) -> str:
    """Write a host as URLs and Host headers do: lower case, an IPv6 address in brackets."""
    host = host.lower()
    return f"[{host}]" if ":" in host and not host.startswith("[") else host


def url_of(host: str, port: int | str) -> str:
    """Return where this machine finds a service that listens on a host and port."""
    return f"http://{WILDCARDS.get(host) or as_url_host(host)}:{port}"


def is_on_loopback(url: str) -> bool:
    """Whether a URL leads to this machine alone."""
    host = urlsplit(url).hostname or ""
    with suppress(ValueError):
        return ip_address(host).is_loopback
    return host in LOOPBACK_HOSTS
