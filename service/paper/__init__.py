"""The paper's evaluation as this system runs it: sweeps, and results as files."""
