"""Graphs of quantities: the texts of --plot, the quantities that they name, and the graphs of a motion.

It knows columns and quantities; the library asks it.
"""
