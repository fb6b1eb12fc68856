"""Data directories of releases, to be upgraded by the present code."""
