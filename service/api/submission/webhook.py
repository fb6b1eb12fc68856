"""Webhooks that the service may not call."""

from collections.abc import Collection

from service.api.refusals.problems import Fault, InvalidRequest
from service.model.webhook import refusal


def refuse_webhook(url: str | None, hosts: Collection[str]) -> None:
    """Raise InvalidRequest for a URL whose host may not be called."""
    if url is not None and (said := refusal(url, hosts)):
        raise InvalidRequest([Fault("webhook", said)])
