"""Refusals of the store."""

from service.refusal import RefusalError


class NotFoundError(LookupError):
    """There is no sweep or run of that name."""


class ImpossibleMoveError(ValueError):
    """The state of the run, sweep or user does not allow the move; the text says why."""


class SubmissionKeyReusedError(ValueError):
    """Another request was submitted under this key; the text says which sweep."""


class TooManyAskedError(RuntimeError):
    """Too many diagnoses would wait; the text says how many do."""


class UnsafeSQLiteError(RefusalError):
    """This SQLite can corrupt the database."""


class MissingDriverError(RefusalError):
    """The driver of this kind of database is not installed."""


class TransferError(RuntimeError):
    """A database cannot be copied exactly; the text says what is wrong."""


class OutdatedTablesError(RefusalError):
    """The database's tables are not this version's."""


class DatabaseInUseError(RefusalError):
    """Another service works on this database."""


class NewerTablesError(RefusalError):
    """A newer version of this service made the database's tables."""


class UnusableDatabaseError(RefusalError):
    """The database cannot be opened: it is damaged, not a database, or unreachable."""


class UnfitServerError(RefusalError):
    """The database's server is too old, or the database's encoding cannot hold every text."""
