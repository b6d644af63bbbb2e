"""Numerical kernels: plain Python functions over arrays, run as they are or compiled."""
