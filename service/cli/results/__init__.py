"""The commands that show, draw and check what was measured."""
