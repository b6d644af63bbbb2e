"""Curves of positions followed by their length: through limits of the input and where branches meet."""
