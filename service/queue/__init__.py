"""The queue: which worker trains what, when."""
