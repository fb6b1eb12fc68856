"""The table of the figures to hold."""
