"""The service's own token: one per data directory, in a file that its owner alone can read.

Its holder is the administrator.
"""

import os
import secrets
from pathlib import Path

from service.data_dir import make_private
from service.refusal import RefusalError
from service.settings import Settings

TOKEN_BYTES = 24
FILE_NAME = "token"
WEBHOOK_FILE_NAME = "webhook-secret"


class ExposedTokenError(RefusalError):
    """Other users can read the token's file."""


def access_token(settings: Settings) -> str:
    """Return `settings.token`, else the data directory's token, made at first use (mode 0600).

    Raises ExposedTokenError when other users can read the file: its token is no secret any more.
    """
    if settings.token is not None:
        return settings.token.get_secret_value()
    make_private(settings.data_dir)
    file = settings.data_dir / FILE_NAME
    _create_unless_there(file)
    if file.stat().st_mode & 0o077:
        raise ExposedTokenError(
            f"{file} can be read by other users, so its token is no secret: delete it (the next "
            "start makes a new one) or, if you trust them, run: chmod 600 " + str(file)
        )
    return file.read_text(encoding="utf-8").strip()


def webhook_secret(settings: Settings) -> str:
    """Return `settings.webhook_secret`, else that of a file, made at first use (mode 0600)."""
    if settings.webhook_secret is not None:
        return settings.webhook_secret.get_secret_value()
    file = settings.data_dir / WEBHOOK_FILE_NAME
    _create_unless_there(file)
    return file.read_text(encoding="utf-8").strip()


def _create_unless_there(file: Path) -> None:
    """Write a new token whole or not at all, and never over another process's."""
    if file.exists():
        return
    draft = file.with_name(f".{file.name}-{secrets.token_hex(8)}")
    descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as stream:
            stream.write(secrets.token_hex(TOKEN_BYTES) + "\n")
            stream.flush()
            os.fsync(stream.fileno())
        # A link fails where a rename would replace the token that another process just made.
        os.link(draft, file)
    except FileExistsError:
        pass
    finally:
        draft.unlink()
