"""Shares: links by which anybody can read some sweeps, for a time."""

from http import HTTPStatus

from fastapi import APIRouter, Request

from service.api.access.authority import MAY_READ, MAY_SUBMIT
from service.api.access.links import link_to
from service.api.context import TheCaller, TheRegister, TheStore, may_be_id
from service.api.refusals.problems import Fault, InvalidRequest, NotFound, printable, refusing
from service.api.schemas.people import NewShareAnswer, ShareAnswer, ShareRequest
from service.model.caller import Caller, Share
from service.store.store import Store

router = APIRouter(prefix="/shares", tags=["people"])


@router.get("", dependencies=[MAY_READ])
def list_shares(caller: TheCaller, register: TheRegister) -> list[ShareAnswer]:
    """List the caller's shares that have not expired; for an administrator, those of all users."""
    return [ShareAnswer.of(share) for share in _of(caller, register)]


@router.post("", status_code=HTTPStatus.CREATED, dependencies=[MAY_SUBMIT])
def add_share(
    asked: ShareRequest,
    request: Request,
    caller: TheCaller,
    register: TheRegister,
    store: TheStore,
) -> NewShareAnswer:
    """Make a link that opens a page without signing in. The answer shows it this once.

    Anybody who has it can read all of these sweeps until it expires, and nothing else.
    """
    _refuse_unknown(asked.sweeps, store)
    sweeps, page = tuple(asked.sweeps), asked.opened
    share, token = refusing(lambda: register.add_share(sweeps, page, asked.days, caller.name))
    link = link_to(request, f"/signin#share={token}")
    return NewShareAnswer(**ShareAnswer.of(share).model_dump(), link=link)


@router.delete("/{share_id}", dependencies=[MAY_READ])
def revoke_share(share_id: str, caller: TheCaller, register: TheRegister) -> ShareAnswer:
    """Revoke a share at once."""
    for share in _of(caller, register):
        if share.id == share_id:
            register.remove_share(share_id)
            return ShareAnswer.of(share)
    raise NotFound(f"There is no share {printable(share_id)!r} of yours.")


def _of(caller: Caller, register: TheRegister) -> list[Share]:
    return [share for share in register.shares() if caller.may_change(share.made_by)]


def _refuse_unknown(sweeps: list[str], store: Store) -> None:
    """Raise InvalidRequest with every sweep that does not exist."""
    known = store.sweep_owners([each for each in sweeps if may_be_id(each)])
    faults = [
        Fault(f"sweeps[{place}]", f"there is no sweep {printable(each)!r}")
        for place, each in enumerate(sweeps)
        if each not in known
    ]
    if faults:
        raise InvalidRequest(faults)
