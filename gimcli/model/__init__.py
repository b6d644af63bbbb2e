"""The model file: schema, reading with line numbers, checks, units, laws, and the compiler."""
