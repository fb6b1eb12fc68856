"""Checkpoints: where runs are left, and taken up again."""
