"""What callers may do: every route says which scope it needs.

    @router.get("/sweeps", dependencies=[MAY_READ])

`refuse_undeclared` finds routes that say nothing, and the application does not start with one.
Only its owner and administrators may change the sweep or run that a path names. A caller with a
shared link sees only the sweeps that it shares: paths that name one of them, and routes that say
`MAY_SEE_SHARED`, which show such a caller nothing else.
"""

from collections.abc import Iterator, Mapping
from http import HTTPStatus
from typing import Annotated, Any

from fastapi import Depends, FastAPI, Request, Security
from fastapi.routing import iter_route_contexts
from fastapi.security import HTTPBearer, SecurityScopes
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.routing import Mount

from service.api.access.guard import is_public
from service.model.caller import Caller, Scope
from service.model.run_name import RunName
from service.store.store import Store

SHARED = "shared"
BEARER = HTTPBearer(
    scheme_name="token",
    description="The service's token, or a user's; `d3pg token` prints the first.",
    auto_error=False,
)


class UndeclaredScopeError(RuntimeError):
    """A route does not say who may call it."""


async def authorise(
    request: Request,
    needed: SecurityScopes,
    _documented: Annotated[object, Depends(BEARER)] = None,
) -> None:
    """Refuse a caller that may not do what a route is for."""
    caller: Caller = request.state.caller
    scope = Scope(needed.scopes[0])
    if not caller.scope.includes(scope):
        _refuse(
            f"This needs the scope {scope.value!r}, but the token of {caller.name} has the scope "
            f"{caller.scope.value!r}. An administrator can make another: `d3pg users add`."
        )
    sweep_id = _sweep_of(request.path_params)
    if not caller.sees(sweep_id) and SHARED not in needed.scopes:
        _refuse("This was not shared with you: the link that you followed opens other sweeps.")
    if scope is Scope.SUBMIT and sweep_id is not None:
        await run_in_threadpool(_refuse_others, caller, sweep_id, request.app.state.store)


def open_to_all() -> None:
    """Declare that a route is open to everybody."""


MAY_SCRAPE = Security(authorise, scopes=[Scope.METRICS.value])
MAY_READ = Security(authorise, scopes=[Scope.READ.value])
MAY_SEE_SHARED = Security(authorise, scopes=[Scope.READ.value, SHARED])
MAY_SUBMIT = Security(authorise, scopes=[Scope.SUBMIT.value])
MAY_ADMINISTER = Security(authorise, scopes=[Scope.ADMIN.value])
OPEN = Depends(open_to_all)
DECLARATIONS = (authorise, open_to_all)


def not_theirs(sweep_id: str, owner: str) -> str:
    """Return why a caller cannot change a sweep."""
    return f"sweep {sweep_id} is of {owner}: only {owner} or an administrator can change it"


def refuse_undeclared(app: FastAPI) -> None:
    """Raise UndeclaredScopeError with every route that does not say who may call it."""
    if found := sorted(set(undeclared(app))):
        raise UndeclaredScopeError(
            f"{', '.join(found)}: these routes do not say who may call them. Give each, or its "
            "router, dependencies=[MAY_READ] or another one of service.api.access.authority."
        )


def undeclared(app: FastAPI) -> Iterator[str]:
    """Yield the paths of routes that do not say who may call them, or say it twice."""
    for route in iter_route_contexts(app.routes):
        path = route.path or ""
        if isinstance(route.original_route, Mount):
            if not is_public(f"{path}/"):
                yield path
        elif len(declared(route)) != 1:
            yield path


def declared(route: Any) -> list[frozenset[str]]:
    """Return the scopes that a route declares; an empty set if it is open."""
    dependencies = getattr(getattr(route, "dependant", None), "dependencies", [])
    return [
        frozenset(each.own_oauth_scopes or ()) for each in dependencies if each.call in DECLARATIONS
    ]


def _sweep_of(path: Mapping[str, Any]) -> str | None:
    """Return the id of the sweep that a path belongs to."""
    run_id = path.get("run_id")
    return path.get("sweep_id") if run_id is None else RunName.parse(run_id).sweep_id


def _refuse_others(caller: Caller, sweep_id: str, store: Store) -> None:
    """Refuse a caller who may not change a sweep; the route reports a missing one."""
    for owner in store.sweep_owners([sweep_id]).values():
        if not caller.may_change(owner):
            text = not_theirs(sweep_id, owner)
            _refuse(f"{text[0].upper()}{text[1:]}.")


def _refuse(detail: str) -> None:
    raise HTTPException(HTTPStatus.FORBIDDEN, detail)
