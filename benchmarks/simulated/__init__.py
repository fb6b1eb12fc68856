"""The parts that benchmarks simulate in order to measure the rest."""
