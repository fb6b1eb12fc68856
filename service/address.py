"""Addresses: hosts as URLs write them, and where a service that listens on one is found."""

import re
from contextlib import suppress
from dataclasses import dataclass
from ipaddress import ip_address
from urllib.parse import urlsplit

LOOPBACK_HOSTS = frozenset({"127.0.0.1", "localhost", "[::1]"})
WILDCARDS = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}  # noqa: S104 - recognised, not bound
"""Addresses that mean every interface, and where this machine reaches such a service."""

SCHEMES = {"http": 80, "https": 443}
PREFIX = re.compile(r"(/(?!\.{1,2}(/|$))[\w.~-]+)*", re.ASCII)


@dataclass(frozen=True)
class Public:
    """Where browsers and clients find the service, behind a proxy or not.

    origin  scheme, host and port, such as https://lab.example
    prefix  what all paths begin with, such as /d3pg; mostly empty
    """

    origin: str
    prefix: str = ""

    @property
    def url(self) -> str:
        """The address that paths are appended to."""
        return f"{self.origin}{self.prefix}"

    @property
    def host(self) -> str:
        """The host, as URLs write it."""
        return as_url_host(urlsplit(self.origin).hostname or "")

    @property
    def is_secure(self) -> bool:
        """Whether connections to it are encrypted."""
        return self.origin.startswith("https://")


def public_of(url: str) -> Public:
    """Read a public URL. Raises ValueError for anything else."""
    parts = urlsplit(url)
    prefix = parts.path.rstrip("/")
    is_plain = not (parts.query or parts.fragment or "@" in parts.netloc)
    if parts.scheme not in SCHEMES or not parts.hostname or not is_plain or parts.port == 0:
        raise ValueError(
            "is not an address of a service: write https://HOST, https://HOST:PORT or "
            "https://HOST/PREFIX"
        )
    if not PREFIX.fullmatch(prefix):
        raise ValueError(
            f"has the path {prefix!r}: it may hold letters, digits and -._~ between its slashes"
        )
    port = "" if parts.port in {None, SCHEMES[parts.scheme]} else f":{parts.port}"
    return Public(f"{parts.scheme}://{as_url_host(parts.hostname)}{port}", prefix)


def as_url_host(host: str) -> str:
    """Write a host as URLs and Host headers do: lower case, an IPv6 address in brackets."""
    host = host.lower()
    return f"[{host}]" if ":" in host and not host.startswith("[") else host


def url_of(host: str, port: int | str, scheme: str = "http") -> str:
    """Return where this machine finds a service that listens on a host and port."""
    return f"{scheme}://{WILDCARDS.get(host) or as_url_host(host)}:{port}"


def is_on_loopback(url: str) -> bool:
    """Whether a URL leads to this machine alone."""
    host = urlsplit(url).hostname or ""
    with suppress(ValueError):
        return ip_address(host).is_loopback
    return host in LOOPBACK_HOSTS
