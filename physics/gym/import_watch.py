"""Import watch: call a function once another package has been imported.

Code that only concerns the users of a package need not make everyone import it.
"""

import sys
from collections.abc import Callable, Sequence
from importlib.machinery import ModuleSpec
from itertools import dropwhile
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.abc import Loader


def when_imported(package: str, action: Callable[[], None]) -> None:
    """Call `action` when `package` has been imported: now, if it has been already."""
    if sys.modules.get(package) is not None:
        action()
    else:
        sys.meta_path.insert(0, _Watch(package, action))


class _Watch:
    """A finder that delegates to the finders behind it, and acts once the found module has run.

    Finding the package without importing it, as `importlib.util.find_spec` does, does not count.
    """

    def __init__(self, package: str, action: Callable[[], None]) -> None:
        self._package = package
        self._action = action

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The package's spec, whose loader also calls the action; None for any other name."""
        if name != self._package:
            return None
        behind = list(dropwhile(lambda finder: finder is not self, sys.meta_path))[1:]
        specs = (finder.find_spec(name, path, target) for finder in behind)
        spec = next(filter(None, specs), None)
        if spec is not None and spec.loader is not None:
            self._act_after(spec.loader)
        return spec

    def _act_after(self, loader: "Loader") -> None:
        """Make this loader call the action after the package's code; change nothing else."""
        run = loader.exec_module

        def run_and_act(module: ModuleType) -> None:
            run(module)
            if self in sys.meta_path:
                sys.meta_path.remove(self)
            self._action()

        loader.exec_module = run_and_act  # type: ignore[method-assign]
