"""Answers that are tables: as records, and as pandas' data frames where pandas is installed."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from service.extras import required


class Tabular(BaseModel, ABC):
    """An answer that can be read row by row."""

    @abstractmethod
    def records(self) -> Iterator[dict[str, Any]]:
        """Yield the rows, each with the same names."""

    def to_pandas(self) -> Any:
        """Return the rows as a `pandas.DataFrame`.

        Raises ModuleNotFoundError, which says what to install, where pandas is missing.
        """
        return required("pandas", "pandas").DataFrame(list(self.records()))
