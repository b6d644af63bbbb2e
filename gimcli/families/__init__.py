"""Families of designs: many mechanisms of one structure that differ in dimensions."""
