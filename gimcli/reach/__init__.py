"""The workspace of a point: the region or path that it reaches, its boundary and inner singular curves.

Knows: curves of critical positions, and what they enclose.
Asks: assemblies, branching, continuation, numerics, positions, structure.
Asked by: families, library.
"""
