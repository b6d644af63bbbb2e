"""Velocities, accelerations and jerks by time, by an input, or along a circuit.

Knows: derivatives of positions, as numbers and as recorded programs.
Asks: calculus, continuation, kernels, motion, numerics, positions, structure.
Asked by: any package above.
"""
