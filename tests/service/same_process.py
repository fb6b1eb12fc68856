"""A side process that is none: work is done where it is asked for."""

from collections.abc import Callable
from pkgutil import resolve_name
from typing import Any

from service.api.load.side_process import always


class SameProcess:
    """Runs what is asked at once."""

    def call(self, function: str, *arguments: Any, is_wanted: Callable[[], bool] = always) -> Any:
        """Run the function."""
        assert is_wanted()
        return resolve_name(function)(*arguments)

    def close(self) -> None:
        """Nothing was started."""
