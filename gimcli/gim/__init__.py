"""The Geometrical-Iterative Method: rules, search for sequences, sweeps and their convergence."""
