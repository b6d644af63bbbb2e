"""Speed and accuracy of several position methods on one motion, with their true errors.

Knows: methods of textbooks beside those of this package; only here mpmath is imported.
Asks: continuation, gim, kernels, motion, positions, structure.
Asked by: cli, library.
"""
