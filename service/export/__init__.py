"""Measurements in the forms of other tools. Each module that needs an extra loads it."""
