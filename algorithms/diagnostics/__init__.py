"""Where a simulator's gradients help a learner on a task, and where they cannot."""
