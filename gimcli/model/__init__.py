"""The model file: schema, reader that keeps line numbers, checks, units, laws, and compiler."""
