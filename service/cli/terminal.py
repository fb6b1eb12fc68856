"""Printing of all commands: tables for people, plain lines for programs, JSON on demand."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterable, Sequence
from typing import Annotated

import typer
from pydantic import BaseModel
from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

MAX_UNFOLDED = 18
"""Characters of a cell, such as an id or a date, that stays on one line."""

PADDING = 2

console = Console()
errors = Console(stderr=True)

AsJson = Annotated[bool, typer.Option("--json", help="Print the service's answer as JSON.")]

Rows = Iterable[Sequence[object]]


def say(text: str, console: Console = console) -> None:
    """Print text without markup or wrapping; control characters become spaces."""
    shown = "".join(each if each.isprintable() or each in "\n\t" else " " for each in text)
    console.print(shown, markup=False, highlight=False, soft_wrap=True)


def print_json(answer: BaseModel, indent: int | None = 2) -> None:
    """Print an answer of the service; control characters are written as escapes."""
    text = answer.model_dump_json(indent=indent)
    say("".join(each if each.isprintable() or each == "\n" else escaped(each) for each in text))


def escaped(character: str) -> str:
    """Return a character as escapes of JSON, one for each of its UTF-16 units."""
    units = character.encode("utf-16-be")
    return "".join(f"\\u{units[i : i + 2].hex()}" for i in range(0, len(units), 2))


def write_out(parts: Iterable[str]) -> None:
    """Write a text as its parts arrive; on a terminal, without control characters."""
    if not console.is_terminal:
        sys.stdout.writelines(parts)
        return
    rest = ""
    for part in parts:
        lines, end, rest = (rest + part).rpartition("\n")
        if end:
            say(lines)
    if rest:
        say(rest)


def print_table(headings: Sequence[str], rows: Rows, console: Console = console) -> None:
    """Print a table; where there is no terminal, lines with tabs between the cells."""
    if console.is_terminal:
        console.print(table_of(headings, rows, console.width))
        return
    for row in (headings, *rows):
        console.file.write("\t".join(plain(cell) for cell in row) + "\n")


def table_of(headings: Sequence[str], rows: Rows, width: int) -> RenderableType:
    """The table for a terminal of a width: no empty columns, long cells folded, short ones whole.

    If the short cells do not fit beside each other, each row is a paragraph.
    """
    columns = [
        (heading, [plain(cell) for cell in cells])
        for heading, *cells in zip(headings, *rows, strict=True)
    ]
    shown = [(heading, cells) for heading, cells in columns if any(cells) or not cells]
    widths = [max(map(len, (heading, *cells))) for heading, cells in shown]
    least = sum(PADDING + (each if each <= MAX_UNFOLDED else 1) for each in widths)
    if least > width:
        return _paragraphs(shown, width)
    table = Table(box=None, padding=(0, PADDING, 0, 0), header_style="bold")
    for (heading, _), each in zip(shown, widths, strict=True):
        table.add_column(heading, overflow="fold", no_wrap=each <= MAX_UNFOLDED)
    for row in zip(*(cells for _, cells in shown), strict=True):
        table.add_row(*map(Text, row))
    return table


def _paragraphs(columns: Sequence[tuple[str, Sequence[str]]], width: int) -> Group:
    """`4ce281638b71-7, status diverged, learner ddpg noise=0.1, ...`: a row a paragraph."""
    (_, firsts), *others = columns
    lines = [
        ", ".join([first, *(f"{heading} {cells[i]}" for heading, cells in others if cells[i])])
        for i, first in enumerate(firsts)
    ]
    wrapped = (
        textwrap.wrap(line, width, subsequent_indent="  ", break_on_hyphens=False) for line in lines
    )
    return Group(*(Text("\n".join(each)) for each in wrapped))


def plain(cell: object) -> str:
    """A cell as one line of text without control characters."""
    return "".join(each if each.isprintable() else " " for each in str(cell))
