"""Routes to what was measured."""
