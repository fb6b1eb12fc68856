"""The command line of `python -m algorithms`."""
