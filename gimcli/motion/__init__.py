"""Positions and motions: arrays in, results out."""
