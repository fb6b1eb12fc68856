"""Matching: the critic's losses and targets, of values and of gradients."""
