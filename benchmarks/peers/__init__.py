"""Implementations that ours are measured beside."""
