"""What learners share that learn from what they have just lived, and then forget it."""
