"""The service keeps what its OpenAPI document says, whatever it is asked: cases by schemathesis.

Half of the cases conform to the document and half do not; two in three ask for a sweep and a run
that exist. None may be answered with a status of 500 or above, every answer must be one that the
document describes, and what does not conform must be refused.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import pytest
import schemathesis
from fastapi import FastAPI
from hypothesis import HealthCheck, Phase, given
from hypothesis import settings as examples
from hypothesis import strategies as st
from pydantic import BaseModel
from schemathesis import APIOperation, BaseSchema, Case, GenerationMode
from schemathesis.checks import not_a_server_error
from schemathesis.core.result import Ok
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    negative_data_rejection,
    response_headers_conformance,
    response_schema_conformance,
    status_code_conformance,
)
from starlette.testclient import TestClient

from service.api.app import PREFIX
from service.store.store import Store
from tests.service.conftest import BASE_URL, SWEEP, TOKEN
from tests.service.training import RANDOM, random_return, rising, train

CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
    negative_data_rejection,
]
HEADERS = {"Authorization": f"Bearer {TOKEN}", "Host": BASE_URL.removeprefix("http://")}
FEW_EACH, MANY_EACH, MANY = 5, 850, 20_000
FILES = ("image/png", "image/svg+xml", "application/pdf", "application/vnd.apache.parquet")
"""Of bytes, which no document shows."""
Json = dict[str, Any]
Operation = APIOperation[Any, Any, Any, Any]
AnyCase = Case[Any]


class EmptyPictures:
    """Draws nothing and plays nothing: what is drawn has tests of its own."""

    def call(self, function: str, *arguments: Any, is_wanted: Callable[[], bool]) -> Any:
        if function.endswith(":picture"):
            return {"styles": [], "frames": [[]], "views": [[0.0, 0.0, 1.0, 1.0]]}
        return None if "rollout" in function else b"a picture"

    def close(self) -> None:
        """Nothing was started."""


@pytest.fixture
def sweeps(store: Store, client: TestClient) -> list[str]:
    """A sweep that has been trained, and one that waits."""
    for environment in SWEEP["environments"]:
        store.record_random_return(random_return(environment, RANDOM))
    trained = client.post(f"{PREFIX}/sweeps", json=SWEEP).json()["id"]
    train(store, 5, rising)
    return [trained, client.post(f"{PREFIX}/sweeps", json=SWEEP).json()["id"]]


@pytest.fixture
def schema(app: FastAPI) -> BaseSchema:
    """The service's document."""
    app.state.side = EmptyPictures()
    for path in app.openapi()["paths"].values():
        for operation in path.values():
            operation.pop("security", None)  # every case is sent with the token
    loaded = schemathesis.openapi.from_asgi(f"{PREFIX}/openapi.json", app, headers=HEADERS)
    loaded.config.max_stream_events = 1  # else a stream is read until that times out
    return loaded


def operations(schema: BaseSchema) -> list[Operation]:
    return [found.ok() for found in schema.get_all_operations() if isinstance(found, Ok)]


def statuses(operation: Operation, sweeps: Sequence[str], cases: int) -> Counter[int]:
    """Check so many cases of an operation, and count their answers."""
    seen: Counter[int] = Counter()
    modes = [operation.as_strategy(mode) for mode in GenerationMode]

    @examples(
        max_examples=cases,
        database=None,
        deadline=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(case=st.one_of(modes), sweep=st.sampled_from([*sweeps, None]))
    def check(case: AnyCase, sweep: str | None) -> None:
        if sweep is not None:
            ask_for(case, sweep)
        response = case.call_and_validate(headers=HEADERS, checks=CHECKS)
        seen[response.status_code] += 1

    check()
    return seen


def ask_for(case: AnyCase, sweep: str) -> None:
    """Have a case ask for what there is; else almost all end at a name that there is not."""
    existing = {"sweep_id": sweep, "run_id": f"{sweep}-0"}
    case.path_parameters |= {key: existing[key] for key in existing.keys() & case.path_parameters}
    body: Any = case.body
    if case.meta and case.meta.generation.mode.is_positive and isinstance(body, dict):
        for algorithm in body.get("algorithms") or []:
            algorithm |= {"name": "hybrid-ddpg", "config": {}}
        replaced = {"environments": ["Pendulum"], "run": existing["run_id"]}
        body |= {key: replaced[key] for key in replaced.keys() & body.keys()}


def test_answers_are_those_of_the_document(schema: BaseSchema, sweeps: Sequence[str]) -> None:
    for operation in operations(schema):
        assert max(statuses(operation, sweeps, FEW_EACH)) < 500


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_twenty_thousand_answers_are_those_of_the_document(
    schema: BaseSchema, sweeps: Sequence[str]
) -> None:
    seen: Counter[int] = Counter()
    for operation in operations(schema):
        found = statuses(operation, sweeps, MANY_EACH)
        print(operation.label, dict(sorted(found.items())), flush=True)  # noqa: T201
        seen += found
    print(f"{seen.total()} cases: {dict(sorted(seen.items()))}")  # noqa: T201
    assert seen.total() >= MANY
    assert max(seen) < 500


def test_every_operation_has_an_example_of_its_answer(client: TestClient) -> None:
    document = client.get(f"{PREFIX}/openapi.json").json()
    for path, methods in document["paths"].items():
        for operation in methods.values():
            for status, response in operation["responses"].items():
                for media_type, content in response["content"].items():
                    if media_type not in FILES:
                        assert has_example(document, content), (path, status, media_type)


def has_example(document: Json, content: Json) -> bool:
    """Whether the content has an example, or its schema; of a list's items is enough."""
    if "example" in content:
        return True
    schema: Json = content["schema"]
    while reference := schema.get("$ref"):
        schema = document["components"]["schemas"][reference.rpartition("/")[2]]
    if "examples" in schema:
        return True
    properties: Json = schema.get("properties", {})
    items = schema.get("items") or properties.get("items", {}).get("items")
    if items:
        return has_example(document, {"schema": items})
    return bool(properties) and all("examples" in each for each in properties.values())


def test_examples_are_answers_that_could_be(client: TestClient) -> None:
    """By their models: FastAPI leaves nulls out of the document's examples."""
    del client
    models = [model for model in descendants(BaseModel) if model.__module__.startswith("service.")]
    extras: list[Any] = [model.model_config.get("json_schema_extra") for model in models]
    described = [
        (model, extra["examples"]) for model, extra in zip(models, extras, strict=True) if extra
    ]
    assert len(described) >= 10
    for model, listed in described:
        for example in listed:
            model.model_validate(example)


def descendants(model: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for below in model.__subclasses__():
        yield below
        yield from descendants(below)
