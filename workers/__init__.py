"""A run as a value, running it, and the Ray actor that does."""
