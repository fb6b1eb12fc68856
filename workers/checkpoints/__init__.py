"""Checkpoints: where runs are left and resumed."""
