"""Claiming: what changes a run's status."""
