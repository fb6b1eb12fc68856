"""What a sweep is to find out: a question, or the best of a search."""
