"""The Geometrical-Iterative Method: rules, search for sequences, sweeps and their convergence.

Knows: the order in which restrictions are imposed, and why.
Asks: kernels, positions, structure.
Asked by: cli, comparison, library, motion.
"""
