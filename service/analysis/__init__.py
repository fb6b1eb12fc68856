"""Analysis: curves, comparisons, statistics and figures of what was measured."""
