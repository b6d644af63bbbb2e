"""Fitting: dimensions for which a point, a member or an output passes given targets.

Knows: targets, goals and conditions, and the searches for the designs that satisfy them.
Asks: calculus, families, language, positions, quantities.
Asked by: library.
"""
