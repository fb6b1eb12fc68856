"""What the benchmarks measure beside this project: one peer a file."""
