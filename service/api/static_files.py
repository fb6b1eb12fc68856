"""The files that pages are made of: their version, and the modules that each script imports.

They are read once, when the service starts. After a change of one, restart the service, as after a
change of its code.
"""

import hashlib
import posixpath
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

# import "a"; import b from "a"; import * as c from "a"; export { d } from "a"; on several lines too
IMPORT = re.compile(r"""^(?:import|export)\b(?:[\w$*{},\s]+\bfrom)?\s*["']([^"']+)["']""", re.M)


class UnresolvedImportError(ValueError):
    """Modules import files that do not exist."""


class StaticFolder:
    """A folder of static files."""

    def __init__(self, folder: Path) -> None:
        """Read the folder; UnresolvedImportError names all imports that lead nowhere."""
        self.folder = folder
        contents = {
            path.relative_to(folder).as_posix(): path.read_bytes()
            for path in sorted(folder.rglob("*"))
            if path.is_file()
        }
        self.version = _version(contents)
        self.imports = _imports(contents)

    def modules(self, script: str) -> tuple[str, ...]:
        """Return a script and all modules that it imports, the nearest first."""
        found = [script]
        for name in found:
            found += [each for each in self.imports[name] if each not in found]
        return tuple(found)


def _version(contents: Mapping[str, bytes]) -> str:
    """Return a text that changes when a file does."""
    hashes = [(name, hashlib.sha256(content).hexdigest()) for name, content in contents.items()]
    return hashlib.sha256(repr(hashes).encode()).hexdigest()[:12]


def _imports(contents: Mapping[str, bytes]) -> dict[str, tuple[str, ...]]:
    """Return what each module imports itself, by name, each once."""
    imports = {}
    faults = []
    for module, content in contents.items():
        if not module.endswith(".js"):
            continue
        named = dict.fromkeys(IMPORT.findall(content.decode()))
        targets = {each: _target(module, each) for each in named}
        faults += [f"{module} imports {each!r}" for each in named if targets[each] not in contents]
        imports[module] = tuple(dict.fromkeys(targets.values()))
    _refuse(faults)
    return imports


def _target(module: str, named: str) -> str:
    """Return the name of the file that an import of a module leads to; "" where it is no path."""
    if not named.startswith(("./", "../")):
        return ""
    return posixpath.normpath(posixpath.join(posixpath.dirname(module), named))


def _refuse(faults: Sequence[str]) -> None:
    if faults:
        raise UnresolvedImportError(
            f"{'; '.join(faults)}: there is no such file. An import names the path from the module "
            "that it stands in, such as './chart.js' or '../parts/element.js'."
        )
