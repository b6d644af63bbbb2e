"""Quantities: what may be asked of a motion, of designs, or of any other state. Each family has one file.

Knows: name, unit and formula of each quantity, its needs, ranges and extremes.
Asks: calculus, dynamics, language, motion, numerics, positions, rates, structure.
Asked by: cli, families, fitting, graphs, library, view.
"""
