"""Times in JSON: UTC, with six digits after the second, so that their texts sort as they do."""

from datetime import UTC, datetime
from typing import Annotated

from pydantic import PlainSerializer, WithJsonSchema


def as_time(seconds: float) -> datetime:
    """Return seconds since 1970 as a time in UTC."""
    return datetime.fromtimestamp(seconds, UTC)


def text(time: datetime) -> str:
    """Return a time in UTC as RFC 3339 writes it: `2026-11-24T09:30:00.000000Z`."""
    return f"{time.astimezone(UTC).replace(tzinfo=None).isoformat(timespec='microseconds')}Z"


Moment = Annotated[
    datetime,
    PlainSerializer(text, return_type=str, when_used="json"),
    WithJsonSchema({"type": "string", "format": "date-time"}, mode="serialization"),
]
