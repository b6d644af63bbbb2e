"""Graphs and animations of motions: the texts of --plot, the quantities that they name, and the rows that are shown.

Knows: what of a motion is drawn; `output` draws it.
Asks: branching, continuation, dynamics, language, motion, output, positions, quantities, rates.
Asked by: families, library.
"""
