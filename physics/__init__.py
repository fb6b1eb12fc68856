"""The tasks: exact simulators, their derivatives, their Gymnasium face."""
