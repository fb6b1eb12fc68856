"""The pool: the service's end of its workers."""
