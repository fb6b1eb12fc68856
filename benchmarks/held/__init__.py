"""The figures to hold, measured by one command: see `__main__`."""
