"""Fitting of dimensions to targets and goals."""
