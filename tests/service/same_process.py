"""A side process that is none: work is done where it is asked for."""

from pkgutil import resolve_name
from typing import Any


class SameProcess:
    """Runs what is asked at once."""

    def call(self, function: str, *arguments: Any) -> Any:
        """Run the function."""
        return resolve_name(function)(*arguments)

    def close(self) -> None:
        """Nothing was started."""
