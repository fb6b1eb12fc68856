"""Migrations in order; each can be undone."""
