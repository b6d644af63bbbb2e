"""The Geometrical-Iterative Method: rules, sequences, sweeps and what they cost."""
