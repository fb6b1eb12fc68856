"""The peers with which the benchmarks compare this project, one per file."""
