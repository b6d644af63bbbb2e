"""Families of designs: many mechanisms of one structure that differ in dimensions.

Knows: designs x rows, their quantities and sensitivities, samples, and the jobs, tables and pictures of sweeps.
Asks: any package below.
Asked by: fitting, library.
"""
