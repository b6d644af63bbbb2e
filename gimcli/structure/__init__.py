"""Structural analysis of a mechanism: what is determined before its positions are solved.

Knows: joints, equations, mobility, groups, and the plan of the solution; each is derived once and kept.
Asks: calculus, kernels.
Asked by: any package above.
"""
