"""Arc-length continuation of curves of positions, through limits of the input and meetings of branches.

Knows: circuits, tangents, folds and crossings of curves.
Asks: numerics, positions, structure.
Asked by: assemblies, branching, comparison, dynamics, graphs, library, motion, rates, reach.
"""
