"""Tasks: one file each, in the same order each."""
