"""What is asked for: a request's entries, grids and plan, and what is added to it."""
