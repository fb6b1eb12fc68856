"""The driver: Ray's end of the workers."""
