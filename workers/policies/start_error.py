"""The error for a start that no episode can have."""


class StartError(ValueError):
    """No episode starts there; the text says why."""
