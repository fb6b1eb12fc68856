"""The paper's evaluation as this system runs it: tuning, sweeps, results."""
