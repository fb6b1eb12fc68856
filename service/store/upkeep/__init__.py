"""Upkeep: backup, copy, upgrade, checks and trouble of the database."""
