"""The form of an answer: by name, by the Accept header, else the first."""

import pytest
from fastapi import Request

from service.api.negotiation import asked_form

TYPES = {"json": "application/json", "csv": "text/csv", "latex": "application/x-latex"}


def request(accept: str) -> Request:
    headers = [(b"accept", accept.encode())] if accept else []
    return Request({"type": "http", "headers": headers})


@pytest.mark.parametrize(
    ("accept", "form"),
    [
        ("", "json"),
        ("*/*", "json"),
        ("text/csv", "csv"),
        ("Text/CSV ; charset=utf-8", "csv"),
        ("application/json, text/csv", "json"),
        ("application/json;q=0.5, text/csv", "csv"),
        ("text/csv;q=0, application/x-latex;q=0.1", "latex"),
        ("text/html, image/png", "json"),
        ("text/csv;q=nan", "json"),
        (";;,,q=", "json"),
    ],
)
def test_accept(accept: str, form: str) -> None:
    assert asked_form(request(accept), None, TYPES) == form


def test_the_name_wins() -> None:
    assert asked_form(request("text/csv"), "latex", TYPES) == "latex"
