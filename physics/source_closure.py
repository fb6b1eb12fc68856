"""The source closure of a module: its own file and every file of the project it imports.

One hash of their contents changes whenever the module's behaviour may.
"""

import ast
import hashlib
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
"""The folder of the project's packages."""


def digest(file: Path) -> str:
    """The hash of a file's closure, 16 hexadecimal digits."""
    result = hashlib.sha256()
    for member in sorted(closure(file)):
        result.update(f"{member.name}\0".encode())
        result.update(member.read_bytes())
    return result.hexdigest()[:16]


def closure(file: Path) -> set[Path]:
    """The file and all it imports, also through others, cycles included."""
    found: set[Path] = set()
    waiting = [file]
    while waiting:
        member = waiting.pop()
        if member not in found:
            found.add(member)
            waiting.extend(_imported(member))
    return found


@cache
def _imported(file: Path) -> frozenset[Path]:
    """The project's files that one file names in its import statements."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    files = (ROOT.joinpath(*name.split(".")).with_suffix(".py") for name in names)
    return frozenset(candidate for candidate in files if candidate.is_file())
