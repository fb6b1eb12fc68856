"""Why the service does not start."""


class RefusalError(RuntimeError):
    """The service does not start; the text says why and what to do."""
