"""Positions of a plan: closed forms and Newton-Raphson, many rows at once."""
