"""Packages of the extras (`pip install 'd3pg[...]'`), or what to install."""

from importlib import import_module
from types import ModuleType


def required(package: str, extra: str) -> ModuleType:
    """Return a package that an extra of d3pg installs.

    Raises ModuleNotFoundError, which says what to install, where it is missing.
    """
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        top = package.partition(".")[0]
        if error.name != top:
            raise
        raise ModuleNotFoundError(
            f"this needs the package {top}: pip install 'd3pg[{extra}]'", name=top
        ) from error
