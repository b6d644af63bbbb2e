"""Inverse dynamics (forces), forward dynamics (simulation), and reduction to one input."""
