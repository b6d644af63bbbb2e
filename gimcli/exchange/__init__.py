"""Files of other programs: each format has a module of its own and a line in `registry.py`."""
