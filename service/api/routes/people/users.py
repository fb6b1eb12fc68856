"""Users: people and programs with tokens of their own."""

from http import HTTPStatus

from fastapi import APIRouter

from service.api.access.authority import MAY_ADMINISTER
from service.api.context import TheRegister
from service.api.refusals.problems import NotFound, printable, refusing
from service.api.schemas.people import NewUserAnswer, UserAnswer, UserRequest
from service.model.caller import User

router = APIRouter(prefix="/users", tags=["people"], dependencies=[MAY_ADMINISTER])


@router.get("")
def list_users(register: TheRegister) -> list[UserAnswer]:
    """List users by name, revoked ones included. The administrator is not one of them."""
    return [UserAnswer.of(user) for user in register.users()]


@router.post("", status_code=HTTPStatus.CREATED)
def add_user(request: UserRequest, register: TheRegister) -> NewUserAnswer:
    """Add a user. The answer shows the token this once. 409 if the name is in use.

    A user who was revoked gets a new token, and their sweeps back.
    """
    token = refusing(lambda: register.add_user(request.name, request.scope))
    user = UserAnswer.of(_found(request.name, register))
    return NewUserAnswer(**user.model_dump(), token=token)


@router.delete("/{name}")
def revoke_user(name: str, register: TheRegister) -> UserAnswer:
    """Revoke a user at once: token, sessions and shares. The user's sweeps stay."""
    _found(name, register)
    register.revoke_user(name)
    return UserAnswer.of(_found(name, register))


def _found(name: str, register: TheRegister) -> User:
    for user in register.users():
        if user.name == name:
            return user
    raise NotFound(f"There is no user {printable(name)!r}.")
