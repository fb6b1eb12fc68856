"""What is wrong with the form of a request, field by field, and which field was meant."""

from collections.abc import Mapping, Sequence
from typing import Any, get_args

from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from fastapi_problem.error import Problem
from fastapi_problem.handler import ExceptionHandler
from pydantic import BaseModel
from starlette.requests import Request

from service.api.refusals.nearest import unknown_name
from service.api.refusals.problems import Fault, InvalidRequest, faults_of, field_path

Location = Sequence[str | int]


def refuse_invalid(
    _handler: ExceptionHandler, request: Request, error: RequestValidationError
) -> Problem:
    """Answer a request whose form is not that of its route."""
    return InvalidRequest(form_faults(request, error))


def form_faults(request: Request, error: RequestValidationError) -> list[Fault]:
    """Return all that is wrong with a request's form."""
    route = request.scope.get("route")
    return [_fault(route, each) for each in error.errors()]


def _fault(route: Any, error: Mapping[str, Any]) -> Fault:
    location = error["loc"]
    model = _model_at(route, location[:-1]) if error["type"] == "extra_forbidden" else None
    if model is None:
        return faults_of([error])[0]
    return unknown_name(field_path(location), str(location[-1]), list(model.model_fields))


def _model_at(route: Any, location: Location) -> type[BaseModel] | None:
    """Return the model whose fields stand at a location of a route's body or query."""
    if not isinstance(route, APIRoute) or not location:
        return None
    is_body = location[0] == "body"
    parameters = [route.body_field] if is_body else route.dependant.query_params
    declared = [each.field_info.annotation for each in parameters if each]
    model = next((found for each in declared if (found := _model_in(each))), None)
    for part in location[1:]:
        if model is not None and isinstance(part, str) and part in model.model_fields:
            model = _model_in(model.model_fields[part].annotation)
    return model


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """Return the model that an annotation is, or has within: of `list[Weights] | None`, Weights."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((model for each in get_args(annotation) if (model := _model_in(each))), None)
