"""Numerical kernels: plain Python functions over arrays, which can run interpreted or compiled.

Knows: flat arrays of numbers, and how functions are compiled; only here numba is imported.
Asks: no package.
Asked by: any package above.
"""
