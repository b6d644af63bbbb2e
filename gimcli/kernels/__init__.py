"""Numerical kernels: plain Python functions over arrays, which can run interpreted or compiled."""
