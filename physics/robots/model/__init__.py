"""The model of a robot: its description, and the arrays that kernels read."""
