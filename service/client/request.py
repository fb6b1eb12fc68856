"""Requests, as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from service.api.schemas.number import unsayable
from service.api.schemas.requests.sweep_request import SweepRequest
from service.client.errors import ServiceError, faults_text

Request = SweepRequest | Mapping[str, Any]


def as_json(request: Request) -> dict[str, Any]:
    """Return the JSON to post: the fields of a model that were set, or a mapping unchanged.

    Raises ServiceError, with every value that JSON cannot say.
    """
    if isinstance(request, SweepRequest):
        return request.model_dump(mode="json", exclude_unset=True)
    try:
        faults = list(unsayable("", request))
    except RecursionError:
        raise ServiceError("The request contains itself.") from None
    if faults:
        raise ServiceError(faults_text(faults))
    return dict(request)
