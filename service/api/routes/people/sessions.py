"""Sessions: the browsers that are signed in; links that sign in others."""

from http import HTTPStatus

from fastapi import APIRouter, Request

from service.api.access.authority import MAY_READ
from service.api.access.links import link_to, signin_path
from service.api.access.register import CODE_SECONDS
from service.api.context import TheCaller, TheRegister
from service.api.refusals.problems import NotFound, printable
from service.api.schemas.people import SessionAnswer, SignInAnswer, SignInRequest
from service.model.caller import Caller, Session

router = APIRouter(tags=["people"], dependencies=[MAY_READ])


@router.post("/sign-in-links", status_code=HTTPStatus.CREATED)
def add_sign_in_link(
    asked: SignInRequest, request: Request, caller: TheCaller, register: TheRegister
) -> SignInAnswer:
    """Make a link that signs one browser in as the caller, within ten minutes."""
    link = link_to(request, signin_path(register.new_code(caller), asked.page))
    return SignInAnswer(link=link, seconds=CODE_SECONDS)


@router.get("/sessions")
def list_sessions(caller: TheCaller, register: TheRegister) -> list[SessionAnswer]:
    """List the caller's signed-in browsers; for an administrator, those of all users."""
    return [SessionAnswer.of(session) for session in _of(caller, register)]


@router.delete("/sessions/{session_id}")
def end_session(session_id: str, caller: TheCaller, register: TheRegister) -> SessionAnswer:
    """Sign a browser out, at once."""
    for session in _of(caller, register):
        if session.id == session_id:
            register.end_session(session_id)
            return SessionAnswer.of(session)
    raise NotFound(f"There is no session {printable(session_id)!r} of yours.")


def _of(caller: Caller, register: TheRegister) -> list[Session]:
    return [each for each in register.sessions() if caller.may_change(each.name)]
