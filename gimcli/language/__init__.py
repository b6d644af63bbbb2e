"""The language of formulas and quantities: expressions, their reader, and their functions for arrays.

Knows: the grammar; what a name stands for is the knowledge of the package that asks.
Asks: no package.
Asked by: families, fitting, graphs, model, quantities.
"""
