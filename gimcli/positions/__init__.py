"""Solution of the steps of a plan: closed forms and Newton-Raphson, many rows at once."""
