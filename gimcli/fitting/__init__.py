"""Fitting: dimensions for which a point, a member or an output passes given targets."""
