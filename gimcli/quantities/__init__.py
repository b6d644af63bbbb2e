"""Quantities: what may be asked of a motion, of designs, or of any other state. Each family has one file."""
