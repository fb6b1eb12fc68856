"""Training: a cohort from its specs to its progress."""
