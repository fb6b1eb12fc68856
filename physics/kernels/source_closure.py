"""The source closure of a module: its own file and every file of its project that it imports.

The hash of their contents changes whenever the module's behaviour may change. The project is this
one, and the package of the module where that belongs to another project. An import from the project
that cannot be resolved to a file is an error: kernels would be taken from the cache although the
code that they call has changed.
"""

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
"""The folder of the project's packages."""
PACKAGES = frozenset({"physics", "algorithms", "workers", "service"})


def digest(file: Path) -> str:
    """The hash of a file's closure, 16 hexadecimal digits.

    Raises:
        ImportError: for an import from the project that does not name a file.
    """
    result = hashlib.sha256()
    for member in sorted(closure(file)):
        result.update(f"{member.relative_to(_root(member))}\0".encode())
        result.update(member.read_bytes())
    return result.hexdigest()[:16]


def closure(file: Path) -> set[Path]:
    """The file and all it imports, also through others, cycles included.

    Raises:
        ImportError: as `digest`.
    """
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
    """The files that one file names in its import statements, including those of packages."""
    found: set[Path] = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        for module, *parts in _named(node, file):
            if (root := _home(module, file)) is not None:
                found.update(_files_of(module, root, file))
                for part in parts:
                    found.update(_part(module, part, root, file))
    return frozenset(found)


def _named(node: ast.AST, file: Path) -> Iterator[tuple[str, ...]]:
    """The modules that a node imports, each with the names that it imports from them."""
    if isinstance(node, ast.Import):
        yield from ((alias.name,) for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        base = file.relative_to(_root(file)).parts[: -node.level] if node.level else ()
        module = ".".join([*base, *(node.module or "").split(".")]).strip(".")
        yield (module, *(alias.name for alias in node.names))


def _home(module: str, file: Path) -> Path | None:
    """The folder to search for a module of this project or of the file's package, else None."""
    top = module.partition(".")[0]
    if top in PACKAGES:
        return ROOT
    root = _root(file)
    return root if file.relative_to(root).parts[0] == top else None


@cache
def _root(file: Path) -> Path:
    """The folder that holds a file's outermost package."""
    return next(folder for folder in file.parents if not (folder / "__init__.py").is_file())


def _files_of(module: str, root: Path, file: Path) -> Iterator[Path]:
    """The file of a module, and those of the packages that it lies in."""
    parts = module.split(".")
    for depth in range(1, len(parts)):
        yield root.joinpath(*parts[:depth], "__init__.py")
    if (found := _file_of(module, root)) is None:
        raise ImportError(f"{file} imports {module}, which is not a file of its project")
    yield found


def _part(module: str, part: str, root: Path, file: Path) -> Iterator[Path]:
    """The file of a name that is imported from a module, if the name is itself a module."""
    inside = _file_of(module, root)
    if (found := _file_of(f"{module}.{part}", root)) is not None:
        yield found
    elif inside is not None and inside.name == "__init__.py" and part not in _bound(inside):
        raise ImportError(f"{file} imports {part} from {module}, but no file defines it")


@cache
def _file_of(module: str, root: Path) -> Path | None:
    """The file of a module or of a package."""
    path = root.joinpath(*module.split("."))
    candidates = (path.with_suffix(".py"), path / "__init__.py")
    return next((candidate for candidate in candidates if candidate.is_file()), None)


@cache
def _bound(file: Path) -> frozenset[str]:
    """The names that a file binds by statements, without those that are bound at use."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import | ast.ImportFrom):
            names.update((alias.asname or alias.name).partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
    return frozenset(names)
