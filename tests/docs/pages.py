"""The pages of the documentation, and what they show: blocks of code and commands."""

import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [
        *ROOT.glob("*.md"),
        *(ROOT / "docs").rglob("*.md"),
        ROOT / "docker" / "README.md",
        ROOT / "results" / "README.md",
    ]
)
FENCED = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def name_of(page: Path) -> str:
    """A page as links name it."""
    return page.relative_to(ROOT).as_posix()


def blocks(page: Path, *languages: str) -> list[str]:
    """The fenced blocks of these languages."""
    return [code for language, code in FENCED.findall(page.read_text()) if language in languages]


def commands(page: Path) -> Iterator[str]:
    """Each command that a page shows: in blocks one by one, in sentences between backquotes."""
    for block in blocks(page, "sh", "ini", ""):
        for line in re.sub(r"\\\n", " ", block).splitlines():
            yield from re.split(r"[;|&]|\$\(", line.split(" #")[0])
    yield from re.findall(r"`([^`\n]+)`", FENCED.sub("", page.read_text()))
