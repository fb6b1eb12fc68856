"""What `benchmarks/` has that is not a measurement itself."""
