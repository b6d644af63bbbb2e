"""The manual: one page a file, shown by `gim manual` and readable on the web.

Knows: its pages and the tables of options in them.
Asks: no package.
Asked by: cli.
"""
