"""The language of formulas and quantities: expressions, their reader, and their functions for arrays."""
