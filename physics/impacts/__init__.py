"""Impacts: event-driven contact of a body that flies."""
