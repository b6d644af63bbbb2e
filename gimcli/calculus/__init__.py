"""Numbers with derivatives, made from one table of rules: recorded, dual, series and jet numbers."""
