"""Commands whose exit codes 0, 1 and 2 are answers: failures have codes of their own.

    64  the command was called wrongly
    65  the service refused what was asked
    69  no service answered, or its answer could not be written
    70  a fault in d3pg, with its traceback

They are those of sysexits.h. A script that acts on an answer never takes a failure for one.
"""

from __future__ import annotations

import os
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer
from rich.console import Console
from typer.core import TyperCommand

from service.cli.terminal import say
from service.client import ServiceError

USAGE_OF_OTHERS = 2
"""The exit code of typer for a command that was called wrongly."""


class AnsweringCommand(TyperCommand):
    """A command that exits with 0, 1 or 2 by its answer alone."""

    def make_context(self, *args: Any, **extra: Any) -> Any:
        """Read the command's arguments."""
        with trouble_apart():
            return super().make_context(*args, **extra)

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        with trouble_apart():
            return super().invoke(ctx)


@contextmanager
def trouble_apart() -> Iterator[None]:
    """Make failures exit with codes above those of answers."""
    try:
        yield
    except ServiceError as error:
        raise _said(error, _code(error)) from error
    except OSError as error:
        raise _said(error, os.EX_UNAVAILABLE) from error
    except Exception as error:
        code = getattr(error, "exit_code", None)
        if code is None:
            traceback.print_exc()
            raise typer.Exit(os.EX_SOFTWARE) from error
        if code == USAGE_OF_OTHERS and not isinstance(error, typer.Exit):
            error.exit_code = os.EX_USAGE  # type: ignore[attr-defined]
        raise


def _code(error: ServiceError) -> int:
    is_refusal = error.status is not None and error.status < 500
    return os.EX_DATAERR if is_refusal else os.EX_UNAVAILABLE


def _said(error: Exception, code: int) -> typer.Exit:
    say(str(error), Console(stderr=True, style="red"))
    return typer.Exit(code)
