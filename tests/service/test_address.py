"""Addresses as URLs write them."""

import pytest

from service.address import is_on_loopback, url_of


@pytest.mark.parametrize(
    ("host", "url"),
    [
        ("127.0.0.1", "http://127.0.0.1:80"),
        ("::1", "http://[::1]:80"),
        ("[::1]", "http://[::1]:80"),
        ("0.0.0.0", "http://127.0.0.1:80"),  # noqa: S104
        ("::", "http://[::1]:80"),
        ("Lab.Example", "http://lab.example:80"),
    ],
)
def test_where_a_service_is_found(host: str, url: str) -> None:
    assert url_of(host, 80) == url


@pytest.mark.parametrize(
    ("url", "is_here"),
    [
        ("http://127.0.0.1:8000", True),
        ("http://127.0.0.2:8000/lab", True),
        ("http://LOCALHOST", True),
        ("https://[::1]:8000", True),
        ("http://lab.example", False),
        ("http://localhost.lab.example", False),
        ("http://10.0.0.7:8000", False),
        ("http://127.example", False),
    ],
)
def test_what_leads_to_this_machine(url: str, is_here: bool) -> None:
    assert is_on_loopback(url) is is_here
