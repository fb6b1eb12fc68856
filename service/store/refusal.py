"""What the store says no to."""

from service.refusal import RefusalError


class NotFoundError(LookupError):
    """There is no sweep or run of that name."""


class ImpossibleMoveError(ValueError):
    """What is asked cannot happen from where the run, sweep or user stands; the text says why."""


class SubmissionKeyReusedError(ValueError):
    """Another request was submitted under this key; the text says which sweep."""


class TooManyAskedError(RuntimeError):
    """More was asked for than may wait; the text says how much does."""


class UnsafeSQLiteError(RefusalError):
    """This SQLite can corrupt the database."""


class MissingDriverError(RefusalError):
    """What talks to this kind of database is not installed."""


class TransferError(RuntimeError):
    """A copy of a database that would not be one; the text says what is wrong."""


class OutdatedTablesError(RefusalError):
    """The database's tables are not this version's."""


class DatabaseInUseError(RefusalError):
    """Another service works on this database."""


class NewerTablesError(RefusalError):
    """A newer version of this service made the database's tables."""


class UnusableDatabaseError(RefusalError):
    """The database cannot be opened: it is damaged, no database, or not reached."""


class UnfitServerError(RefusalError):
    """The database's server is too old, or the database's encoding cannot hold every text."""
