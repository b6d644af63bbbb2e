"""Files of other programs: each format has a module of its own and a line in `registry.py`.

Knows: their formats, and what of them has no counterpart here.
Asks: model, structure.
Asked by: library.
"""
