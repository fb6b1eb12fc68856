"""The record of everything: sweeps, runs, attempts, measurements, events; SQL and nothing else."""
