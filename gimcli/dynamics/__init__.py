"""Inverse dynamics (forces), forward dynamics (simulation), equilibria, small vibrations, and reduction to one input.

Knows: masses, loads, springs, dampers and friction, and the balance of forces.
Asks: branching, calculus, continuation, kernels, motion, numerics, positions, rates, structure.
Asked by: cli, families, graphs, library, output, quantities.
"""
