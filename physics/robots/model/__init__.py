"""What a robot is: its description, and the arrays that kernels read of it."""
