"""Problem documents in the OpenAPI document: one schema for the refusals of all routes."""

from typing import Any

from fastapi import FastAPI
from pydantic import BaseModel, ConfigDict, Field

from service.api.refusals.problems import MEDIA_TYPE

REFERENCE = "#/components/schemas/{model}"
FRAMEWORK_SCHEMAS = ("HTTPValidationError", "ValidationError")
METHODS = frozenset({"get", "post", "put", "patch", "delete"})


class FaultAnswer(BaseModel):
    """One thing wrong with a request."""

    field: str = Field(description="Where: `algorithms[0].weights.w1`.")
    message: str
    limit: float | str | None = Field(description="The limit that was exceeded; mostly null.")


class Problem(BaseModel):
    """Why something was not done (RFC 9457)."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "type": "invalid-request",
                    "title": "The request is not valid.",
                    "status": 422,
                    "detail": "seeds: 20800 runs; a sweep has at most 20000",
                    "errors": [
                        {
                            "field": "seeds",
                            "message": "20800 runs; a sweep has at most 20000",
                            "limit": 20000,
                        }
                    ],
                    "request_id": "1f0c6a3b5d7e4f6f8a9b0c1d2e3f4a5b",
                }
            ]
        }
    )

    type: str = Field(description="A short name of the kind of problem.")
    title: str
    status: int
    detail: str | None = None
    errors: list[FaultAnswer] | None = Field(
        default=None, description="The faults of an invalid request."
    )
    request_id: str | None = Field(description="The id of this request in the service's log.")


def describe_problems(app: FastAPI) -> None:
    """Declare for every operation that it may answer with a `Problem`, and no other error."""
    answer = {"schema": {"$ref": REFERENCE.format(model=Problem.__name__)}}
    responses = {
        "4XX": {"description": "The request cannot be done.", "content": {MEDIA_TYPE: answer}},
        "5XX": {"description": "The service cannot do it now.", "content": {MEDIA_TYPE: answer}},
    }
    describe = app.openapi

    def described() -> dict[str, Any]:
        document = describe()
        schema = Problem.model_json_schema(ref_template=REFERENCE)
        schemas = document["components"]["schemas"]
        schemas |= {**schema.pop("$defs"), Problem.__name__: schema}
        for name in FRAMEWORK_SCHEMAS:
            schemas.pop(name, None)
        for path in document["paths"].values():
            for operation in (path[method] for method in METHODS & path.keys()):
                operation["responses"].pop("422", None)
                operation["responses"] |= responses
        return document

    app.openapi = described  # type: ignore[method-assign]
