"""The tasks as Gymnasium's environments."""
