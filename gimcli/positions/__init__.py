"""Solution of the steps of a plan: closed forms and Newton-Raphson, many rows at once.

Knows: rows of positions on one branch, and whether kernels are compiled for them.
Asks: kernels, structure.
Asked by: any package above.
"""
