"""Policies: what runs have learned, acting."""
