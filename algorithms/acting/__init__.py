"""Trained policies outside training: as files, in numpy and in torch."""
