"""Questions: whether entries of a sweep differ, answered by looks at any time."""
