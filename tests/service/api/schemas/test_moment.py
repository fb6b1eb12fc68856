"""Times in JSON: one length for all of them, so that their texts sort as the times do."""

from collections.abc import Iterator
from datetime import datetime
from types import UnionType
from typing import get_args

import pytest
from pydantic import BaseModel
from pydantic.fields import FieldInfo

import service.api.app  # noqa: F401 - all answers are loaded with it
from service.api.schemas.moment import Moment, as_time


class Answer(BaseModel):
    at: Moment
    ended_at: Moment | None = None


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "1970-01-01T00:00:00.000000Z"),
        (1_764_000_000.5, "2025-11-24T16:00:00.500000Z"),
        (1_764_000_001.0, "2025-11-24T16:00:01.000000Z"),
    ],
)
def test_a_whole_second_has_six_digits_too(seconds: float, text: str) -> None:
    answer = Answer(at=as_time(seconds), ended_at=as_time(seconds))
    assert answer.model_dump(mode="json") == {"at": text, "ended_at": text}
    assert Answer.model_validate_json(answer.model_dump_json()) == answer


def test_texts_sort_as_the_times_do() -> None:
    seconds = [1.0, 1.25, 1.999999, 2.0, 10.0]
    texts = [Answer(at=as_time(second)).model_dump(mode="json")["at"] for second in seconds]
    assert sorted(texts) == texts


def test_its_schema_is_a_time_s() -> None:
    schema = Answer.model_json_schema(mode="serialization")["properties"]["at"]
    assert (schema["type"], schema["format"]) == ("string", "date-time")


def test_every_time_of_an_answer_is_one() -> None:
    bare = [
        f"{model.__name__}.{name}"
        for model in models(BaseModel)
        if model.__module__.startswith("service.")
        for name, field in model.model_fields.items()
        if is_bare(field)
    ]
    assert bare == []


def models(base: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for model in base.__subclasses__():
        yield model
        yield from models(model)


def is_bare(field: FieldInfo) -> bool:
    """Whether a field is a time that pydantic writes by its own rule."""
    annotation = field.annotation
    parts = get_args(annotation) if isinstance(annotation, UnionType) else (annotation,)
    return datetime in parts and not field.metadata
