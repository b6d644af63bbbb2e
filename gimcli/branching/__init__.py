"""Circuits and their branches, limits, change points and other singular positions.

Knows: which configurations a motion connects, and where inputs reverse.
Asks: assemblies, continuation, motion, numerics, positions, structure.
Asked by: cli, dynamics, graphs, library, output, reach.
"""
