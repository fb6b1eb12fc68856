"""Tasks: one file each, all with the same structure."""
