"""The batches of questions and the rungs of searches: what a sweep is given next, written once."""
