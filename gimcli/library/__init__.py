"""The public functions: one file for each, with the class of its result. The commands call the same functions.

A function takes a mechanism and arguments with the names and units of the model file, checks them and returns a result.
A position that is not solved has a status and NaN. Exceptions are raised only for invalid arguments and models, and for
mechanisms that cannot be driven or assembled.
"""
