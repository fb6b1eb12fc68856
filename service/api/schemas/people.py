"""Users, shares and sessions, as requests and answers show them."""

from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from service.api.place import here
from service.api.schemas.moment import Moment, as_time
from service.api.schemas.requests.sweep_edit import distinct
from service.api.schemas.requests.texts import Name, Request, Text
from service.model.caller import ADMINISTRATOR, Scope, Session, Share, User

MAX_SHARED = 50
MAX_PAGE = 1000
MAX_DAYS = 365
DAYS = 7
TOKEN_TEXT = "Shown only this once: the service keeps only its SHA-256."  # noqa: S105 - a text
SHARE_EXAMPLE: dict[str, Any] = {
    "id": "5be1a40c92d7",
    "sweeps": ["3f9a0c51b7de"],
    "page": "/sweeps/3f9a0c51b7de",
    "made_by": "ann",
    "created_at": "2026-11-24T09:30:00.120000Z",
    "expires_at": "2026-12-01T09:30:00.120000Z",
}


def _user_name(value: str) -> str:
    if value == ADMINISTRATOR:
        raise ValueError("is reserved for the service's own token: choose another name")
    return value


def _page(value: str) -> str:
    is_ours = value.startswith("/") and value[1:2] not in {"/", "\\"} and value.isprintable()
    if not is_ours:
        raise ValueError("is not a page of this service: write its path, such as /compare?sweep=ID")
    return value


UserName = Annotated[
    str,
    Field(pattern=r"^[a-z0-9][a-z0-9._-]{0,31}$", examples=["ann"]),
    AfterValidator(_user_name),
]
PageText = Annotated[Text, Field(min_length=1, max_length=MAX_PAGE), AfterValidator(_page)]


class UserRequest(Request):
    """A user to make."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "ann", "scope": "submit"}]})

    name: UserName = Field(description="Lower case letters, digits, and ._- after the first.")
    scope: Scope = Field(
        strict=False,
        description="metrics: reads /metrics alone; read: reads everything; submit: submits too, "
        "and changes its own sweeps; admin: changes everything, makes users.",
    )


class UserAnswer(BaseModel):
    """A user with a token of their own."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "name": "ann",
                    "scope": "submit",
                    "created_at": "2026-11-24T09:30:00.120000Z",
                    "revoked_at": None,
                }
            ]
        }
    )

    name: str
    scope: Scope
    created_at: Moment
    revoked_at: Moment | None = Field(description="null while the token is valid.")

    @classmethod
    def of(cls, user: User) -> Self:
        """Show a user."""
        revoked_at = None if user.revoked_at is None else as_time(user.revoked_at)
        return cls(
            name=user.name,
            scope=user.scope,
            created_at=as_time(user.created_at),
            revoked_at=revoked_at,
        )


class NewUserAnswer(UserAnswer):
    """A user that was just made."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "name": "ann",
                    "scope": "submit",
                    "created_at": "2026-11-24T09:30:00.120000Z",
                    "revoked_at": None,
                    "token": "kQ3r...",
                }
            ]
        }
    )

    token: str = Field(description=TOKEN_TEXT)


class ShareRequest(Request):
    """Sweeps to share."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"sweeps": ["3f9a0c51b7de"], "days": 7}]}
    )

    sweeps: Annotated[
        list[Name], Field(min_length=1, max_length=MAX_SHARED), AfterValidator(distinct)
    ] = Field(description="Their ids.")
    days: int = Field(default=DAYS, ge=1, le=MAX_DAYS, description="Days until it expires.")
    page: PageText | None = Field(
        default=None,
        description="The page that the link opens, with its view; by default that of the sweep, or "
        "the comparison of several.",
    )

    @property
    def opened(self) -> str:
        """The page that the link opens."""
        if self.page is not None:
            return self.page
        if len(self.sweeps) == 1:
            return f"/sweeps/{self.sweeps[0]}"
        return f"/compare?{'&'.join(f'sweep={each}' for each in self.sweeps)}"


class ShareAnswer(BaseModel):
    """A link by which anybody can read some sweeps, for a time."""

    model_config = ConfigDict(json_schema_extra={"examples": [SHARE_EXAMPLE]})

    id: str
    sweeps: list[str]
    page: str
    made_by: str
    created_at: Moment
    expires_at: Moment

    @classmethod
    def of(cls, share: Share) -> Self:
        """Show a share."""
        return cls(
            id=share.id,
            sweeps=list(share.sweeps),
            page=here(share.page),
            made_by=share.made_by,
            created_at=as_time(share.created_at),
            expires_at=as_time(share.expires_at),
        )


class NewShareAnswer(ShareAnswer):
    """A share that was just made."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {**SHARE_EXAMPLE, "link": "http://127.0.0.1:8000/signin#share=kQ3r..."},
            ]
        }
    )

    link: str = Field(description="The link to send. Shown only this once.")


class SignInRequest(Request):
    """Where a sign-in link leads."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"page": "/sweeps/3f9a0c51b7de"}]})

    page: PageText = Field(default="/", description="The page that it opens.")


class SignInAnswer(BaseModel):
    """A link that signs a browser in as the caller."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [{"link": "http://127.0.0.1:8000/signin?code=kQ3r...", "seconds": 600}]
        }
    )

    link: str = Field(description="It is valid once.")
    seconds: int = Field(description="For how long it is valid.")


class SessionAnswer(BaseModel):
    """A browser that is signed in."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "id": "c01d7a9e44f2",
                    "name": "ann",
                    "browser": "Mozilla/5.0 (X11; Linux x86_64) ...",
                    "created_at": "2026-11-24T09:30:00.120000Z",
                    "expires_at": "2026-12-24T09:30:00.120000Z",
                }
            ]
        }
    )

    id: str
    name: str = Field(description="Name of the user who signed in.")
    browser: str = Field(description="As it called itself.")
    created_at: Moment
    expires_at: Moment

    @classmethod
    def of(cls, session: Session) -> Self:
        """Show a session."""
        return cls(
            id=session.id,
            name=session.name,
            browser=session.browser,
            created_at=as_time(session.created_at),
            expires_at=as_time(session.expires_at),
        )
