"""Methods of numerical mathematics: roots, interpolation, curves that are followed.

Knows: functions of numbers and arrays; nothing of mechanisms.
Asks: no package.
Asked by: any package above.
"""
