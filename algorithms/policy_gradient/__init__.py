"""Policy gradients from environment steps alone."""
