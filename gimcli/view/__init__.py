"""The live view: a local server shows the motion of a model file, and solves it again when the file is saved.

Knows: requests of the page, and the state of the file.
Asks: library, motion, output, positions, quantities, rates.
Asked by: cli.
"""
