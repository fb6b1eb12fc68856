"""`d3pg serve`: run the service. Its flags are the fields of the settings, except for secrets.

Others can read flags in the shell's history and in the list of processes.
"""

from __future__ import annotations

import os
import sys
from inspect import Parameter, Signature
from pathlib import Path
from typing import Any

import typer
from pydantic import SecretStr
from pydantic.fields import FieldInfo

from service.cli.terminal import AsJson
from service.settings import Settings, variable_of


def serve(as_json: bool = False, **given: object) -> None:
    """Run the service here, until Ctrl-C. Each option is also an environment variable.

    Prints a link that signs a browser in; with --json, one line with the link, the address and the
    data directory.
    """
    said = {
        variable_of(name): _text(value) for name, value in given.items() if value not in (None, [])
    }
    command = [sys.executable, "-m", "service", *(["--json"] if as_json else [])]
    os.execve(sys.executable, command, os.environ | said)  # noqa: S606


def is_secret(field: FieldInfo) -> bool:
    """Whether a setting is set by the environment or its file alone."""
    return field.annotation == SecretStr | None


def _text(value: object) -> str:
    return ",".join(map(str, value)) if isinstance(value, list) else str(value)


def _flag(name: str, field: FieldInfo) -> Parameter:
    """Return the flag of a setting, unset by default; the service checks its value."""
    kinds: dict[Any, Any] = {int: int, Path: Path, Path | None: Path}
    kind = kinds.get(field.annotation, str)
    if field.annotation == tuple[Path, ...]:
        kind = list[Path]
    option = typer.Option(None, help=_help(field))
    return Parameter(name, Parameter.KEYWORD_ONLY, default=option, annotation=kind | None)


def _help(field: FieldInfo) -> str:
    is_shown = isinstance(field.default, int | str | Path) and field.default
    return (
        f"{field.description}; {field.default} if unset." if is_shown else f"{field.description}."
    )


_FLAGS = [
    _flag(name, field) for name, field in Settings.model_fields.items() if not is_secret(field)
]
_AS_JSON = Parameter("as_json", Parameter.KEYWORD_ONLY, default=False, annotation=AsJson)
vars(serve)["__signature__"] = Signature([*_FLAGS, _AS_JSON])
