"""Kernels: compiling them, and caching the compiled code."""
