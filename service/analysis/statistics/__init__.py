"""Statistics of the runs of a sweep: scores, tables and tests over seeds and tasks."""
