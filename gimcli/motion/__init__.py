"""Solution of single positions, and of motions along the laws of the inputs.

Knows: branch control, limits, passages of singular positions, and why a position is not assembled.
Asks: continuation, gim, kernels, numerics, positions, structure.
Asked by: any package above.
"""
