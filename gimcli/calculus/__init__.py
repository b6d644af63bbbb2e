"""Numbers with derivatives, made from one table of rules: recorded, dual, series and jet numbers.

Knows: the derivatives of operations and functions; nothing of mechanisms.
Asks: no package.
Asked by: any package above.
"""
