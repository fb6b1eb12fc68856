"""The batches of questions and the rungs of searches, each written once."""
