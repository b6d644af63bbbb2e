"""The library under the command line: one file a verb, each with its result.

A verb takes a mechanism and arguments by the user's names and in the file's units, checks them, and returns a result.
What was not solved has a status and NaN; only bad input and an impossible structure raise.
"""
