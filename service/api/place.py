"""The path below which the service is found; links in answers and pages begin with it."""

from contextvars import ContextVar

from starlette.types import ASGIApp, Receive, Scope, Send

ROOT: ContextVar[str] = ContextVar("root", default="")


def here(path: str) -> str:
    """Return a path of the service, from `/` on, as clients must write it."""
    return f"{ROOT.get()}{path}"


class PublicPrefix:
    """Removes the prefix of the public address from paths, if a proxy has left it there."""

    def __init__(self, app: ASGIApp, prefix: str) -> None:
        """Stand before `app`."""
        self.app = app
        self.prefix = prefix

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on; links of its answer begin with the prefix."""
        if scope["type"] in {"http", "websocket"}:
            ROOT.set(self.prefix)
            scope = {**scope, "path": self._within(scope["path"])}
        await self.app(scope, receive, send)

    def _within(self, path: str) -> str:
        if not path.startswith(f"{self.prefix}/"):
            return "/" if path == self.prefix else path
        return path.removeprefix(self.prefix)
