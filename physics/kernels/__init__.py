"""Kernels: compiling, and keeping what was compiled."""
