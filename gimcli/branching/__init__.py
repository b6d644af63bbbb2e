"""Circuits and their branches, limits, change points and other singular positions."""
