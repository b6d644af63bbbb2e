"""The model file: schema, reader that keeps line numbers, checks, units, laws, and compiler.

Knows: the mechanism as written, with names and units of the file; only here pydantic and yaml are imported.
Asks: calculus, language, numerics.
Asked by: cli, exchange, library.
"""
