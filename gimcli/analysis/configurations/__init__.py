"""All ways to assemble a mechanism at given inputs, and the proof that none is missing."""
