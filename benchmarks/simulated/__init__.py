"""What benchmarks pretend, so as to measure the rest."""
