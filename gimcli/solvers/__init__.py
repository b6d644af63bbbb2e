"""One file a method, under its name in the literature."""
