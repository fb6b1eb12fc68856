"""Which form of a resource a request asks for: by `format=`, else by its Accept header."""

from collections.abc import Mapping
from typing import TypeVar

from fastapi import Request

AnyForm = TypeVar("AnyForm", bound=str)


def asked_form(
    request: Request, named: AnyForm | None, media_types: Mapping[AnyForm, str]
) -> AnyForm:
    """Return the form that was named, else the one accepted with the greatest weight.

    Without either, or if no form is accepted, return the first form. Among forms of equal weight,
    return the first, too.
    """
    if named is not None:
        return named
    weights = _accepted(request.headers.get("accept", ""))
    return max(media_types, key=lambda form: weights.get(media_types[form], 0.0))


def _accepted(header: str) -> dict[str, float]:
    """Read `text/csv, text/markdown;q=0.5` as weights; wildcards leave the choice to us."""
    weights = {}
    for part in header.split(","):
        media_type, *parameters = (text.strip().lower() for text in part.split(";"))
        quality = next((text[2:] for text in parameters if text.startswith("q=")), "1")
        weights[media_type] = float(quality) if quality.replace(".", "", 1).isdecimal() else 0.0
    return weights
