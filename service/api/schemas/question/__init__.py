"""The forms of questions and of verdicts."""
