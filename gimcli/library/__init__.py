"""The public functions: one file for each, with the class of its result. The commands call the same functions.

Knows: arguments and results with the names and units of the model file; every check of an argument is here.
Asks: any package below.
Asked by: cli, view.

A position that is not solved has a status and NaN. Exceptions are raised only for invalid arguments and models, and for
mechanisms that cannot be driven or assembled.
"""
