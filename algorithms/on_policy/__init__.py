"""The shared parts of learners that learn only from the steps of their current policy."""
