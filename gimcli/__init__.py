"""Command-line analyser of planar mechanisms by the Geometrical-Iterative Method."""

__version__ = "0.1.0"
